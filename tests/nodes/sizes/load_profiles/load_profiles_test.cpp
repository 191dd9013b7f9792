#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/export/formats/csv.h"
#include "nodes/sizes/load_profiles/profile_json.h"
#include "nodes/sizes/load_profiles/profile_table.h"
#include "runtime/json_text.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace load_profiles;

Profiles read(const std::string& text, const std::string& unit = "mm") {
  return read_profiles(text, "t.csv", profile_unit(unit));
}

Diagnostic diagnostic_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.diagnostic();
  }
  return {};
}

std::vector<double> areas(const Profiles& p) {
  std::vector<double> a;
  for (const auto& q : p.profiles) a.push_back(q.area);
  return a;
}

TEST(LoadProfiles, TheWaysThatProgramsWrite) {
  const std::vector<double> expected = {1.5, 20};
  EXPECT_EQ(areas(read("Area\tCirc.\n1.5\t0.9\n20\t0.8\n")), expected);
  EXPECT_EQ(areas(read(" \tArea\tMean\r\n1\t1.5\t7\r\n2\t20\t8\r\n")), expected);  // ImageJ numbers the rows
  EXPECT_EQ(areas(read(" \tArea\n1\t1.5\n2\t20\n")), expected);  // ImageJ, with one measurement
  EXPECT_EQ(areas(read("\"Area\",\"Mean\"\n\"1\",1.5,7\n\"2\",20,8\n")),
            expected);  // R writes one column name less
  EXPECT_EQ(areas(read("\xef\xbb\xbfLabel;AREA [mm²]\nthe first, a;1,5\nb;20\n")),
            expected);  // decimal commas
  EXPECT_EQ(areas(read("# made by hand\n1.5\n\n20\n")), expected);
  EXPECT_EQ(areas(read("name, Area (mm2)\n\"x, y\",1.5\nb,2e1\n")), expected);
  EXPECT_EQ(areas(read("area mm²,x\n1.5,0\n20,0\n")), expected);
}

TEST(LoadProfiles, DiametersAndUnits) {
  EXPECT_NEAR(read("Diameter\n2\n").profiles[0].area, std::numbers::pi, 1e-12);
  EXPECT_NEAR(read("ECD\n2000\n", "µm").profiles[0].area, std::numbers::pi, 1e-12);
  EXPECT_NEAR(read("area\n1e6\n", "um").profiles[0].area, 1, 1e-12);
  EXPECT_NEAR(read("area\n1e6\n", "µm²").profiles[0].area, 1, 1e-12);
  EXPECT_NEAR(read("area\n1\n", "cm").profiles[0].area, 100, 1e-12);
  EXPECT_EQ(diagnostic_of([] { profile_unit("furlong"); }).code, "unknown-unit");
}

TEST(LoadProfiles, OwnTablesComeBack) {
  const Profiles p = read(
      "section,class,area,centroid_x,centroid_y,touches_border,weight,confidence,color_r,color_g,color_b\n"
      "0,1,2.5,3,4,0,1.25,0.75,0.1,0.2,0.3\n1,0,7,8,9,1,0,1,0.4,0.5,0.6\n");
  EXPECT_EQ(p.sections, 2);
  EXPECT_EQ(p.classes, 2);
  EXPECT_EQ(p.profiles[0].cls, 1);
  EXPECT_EQ(p.profiles[0].weight, 1.25);
  EXPECT_EQ(p.profiles[0].confidence, 0.75);
  EXPECT_EQ(p.profiles[0].centroid, Vec2(3, 4));
  EXPECT_EQ(p.profiles[1].section, 1);
  EXPECT_TRUE(p.profiles[1].touches_border);
  EXPECT_EQ(p.profiles[1].color, Vec3f(0.4f, 0.5f, 0.6f));
}

TEST(LoadProfiles, TablesOfASurfaceComeBack) {
  Profiles p;
  p.view = View::Surface;
  for (int i = 0; i < 4; ++i) {
    Profile one;
    one.area = 1 + i;
    one.whole = 1.5 + i;
    one.color = Vec3f::Constant(0.4f);
    p.profiles.push_back(one);
  }
  const Profiles back = read_profiles(exporting::csv_of(p), "p.csv", profile_unit("auto"));
  EXPECT_EQ(back.view, View::Surface);
  ASSERT_EQ(back.profiles.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(back.profiles[i].whole, p.profiles[i].whole);
  for (const char* wrong : {"area,view,whole\n1,surface,2\n1,section,2\n", "area,view,whole\n1,above,2\n",
                            "area,view,whole\n1,surface,0.5\n"})
    EXPECT_EQ(test::code_of([&] { read_profiles(wrong, "p.csv", profile_unit("auto")); }), "malformed-row")
        << wrong;
}

TEST(LoadProfiles, TheViewOfATableCanBeTold) {
  const auto folder = test::temporary_folder();
  const auto run = [&](const char* table, const char* view) {
    std::ofstream(folder / "t.csv") << table;
    return test::run_node("LoadProfiles", {},
                          {{"path", (folder / "t.csv").string()}, {"view", view}, {"unit", "mm"}});
  };
  const Profiles told = run("area\n2\n3\n", "surface").output<Profiles>("profiles");
  EXPECT_EQ(told.view, View::Surface);
  EXPECT_EQ(told.profiles[1].whole, 3);
  EXPECT_FALSE(shows_loose_stones(told)) << "the color of the ground is not in the table";
  EXPECT_EQ(run("area\n2\n3\n", "auto").output<Profiles>("profiles").view, View::Section);
  EXPECT_EQ(test::code_of([&] { run("area,view,whole\n2,surface,2\n", "filling"); }), "bad-value");
}

TEST(LoadProfiles, MalformedRowsAreNamed) {
  for (const char* text :
       {"area\n1\nx\n", "area,b\n1,2\n3\n", "area\n1\n-2\n", "area\n1\n0\n", "area\n1\nnan\n",
        "area\n1\ninf\n", "area,class\n1,0\n1,-1\n", "area\n1\n1.5.2\n"}) {
    const Diagnostic d = diagnostic_of([&] { read(text); });
    EXPECT_EQ(d.code, "malformed-row") << text;
    EXPECT_EQ(d.message.rfind("t.csv:3: ", 0), 0u) << d.message;
    EXPECT_EQ(d.parameter, "path");
  }
  EXPECT_EQ(diagnostic_of([] { read("length,width\n1,2\n"); }).code, "no-column");
  EXPECT_EQ(diagnostic_of([] { read("1,2\n3,4\n"); }).code, "no-column");
  EXPECT_EQ(diagnostic_of([] { read(""); }).code, "no-particles");
  EXPECT_EQ(diagnostic_of([] { read("area\n"); }).code, "no-particles");
}

TEST(LoadProfiles, NodeJoinsFilesAndChecksTheArea) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "a.csv") << "area\n1\n2\n";
  std::ofstream(folder / "b.csv") << "area\n3\n";
  const std::string glob = (folder / "*.csv").string();
  const auto run = test::run_node("LoadProfiles", {}, {{"path", glob}, {"observed_area", "12"}});
  const auto& p = run.output<Profiles>("profiles");
  EXPECT_EQ(areas(p), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(p.sections, 2);
  EXPECT_EQ(p.profiles[2].section, 1);
  EXPECT_EQ(p.observed_area, 12);
  EXPECT_DOUBLE_EQ(p.area_fraction, 0.5);
  EXPECT_EQ(diagnostic_of([&] {
              test::run_node("LoadProfiles", {}, {{"path", glob}, {"observed_area", "5"}});
            }).code,
            "area-too-small");
}

Profiles with_outlines() {
  Profiles p;
  p.observed_area = 100.0 / 3;
  p.sections = 3;
  p.classes = 2;
  p.window = Vec2(5, 20.0 / 3);
  p.binder_color = Vec3f(0.1f, 0.2f, 0.3f);
  p.area_fraction = 1.0 / 7;
  p.profiles.resize(2);
  p.profiles[0] = {2, 1, 0.1, Vec2(1.0 / 3, 2), true, 0, 0.7, Vec3f(0.6f, 0.7f, 0.8f), {}};
  p.profiles[1].area = 1e-7;
  p.profiles[1].weight = 1 / 0.7;
  p.profiles[1].contour = {Vec2(0.1, 0), Vec2(1, 0.2), Vec2(-1e-300, 1.0 / 3)};
  return p;
}

std::string json_of(const Profiles& p) { return json_text(value_type<Profiles>().describe(&p)); }

TEST(LoadProfiles, JsonIsReadToTheLastBit) {
  const Profiles p = with_outlines();
  const auto bytes = [](const Profiles& v) {
    BufferWriter w;
    value_type<Profiles>().encode(&v, w);
    return w.buffer;
  };
  const std::string text = json_of(p);
  EXPECT_TRUE(is_json(text));
  EXPECT_FALSE(is_json("area\n1\n"));
  EXPECT_EQ(bytes(read_profiles_json(text, "t.json")), bytes(p));
  EXPECT_EQ(bytes(read_profiles_json("{\"image\": {}, \"profiles\": " + text + "}", "t.json")), bytes(p));
}

TEST(LoadProfiles, WrongJsonIsNamed) {
  const auto code = [](const std::string& from, const std::string& to) {
    std::string text = json_of(with_outlines());
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from << " is not in " << text;
    text.replace(at, from.size(), to);
    const Diagnostic d = diagnostic_of([&] { read_profiles_json(text, "t.json"); });
    EXPECT_NE(d.message.find("t.json"), std::string::npos) << d.message;
    EXPECT_EQ(d.parameter, "path");
    return d.code;
  };
  EXPECT_EQ(code("{", "["), "unreadable-file");
  EXPECT_EQ(code("\"window\"", "\"widow\""), "unreadable-file");
  EXPECT_EQ(code("\"classes\":2", "\"classes\":null"), "unreadable-file");
  EXPECT_EQ(code("\"sections\":3", "\"sections\":-3"), "unreadable-file");
  EXPECT_EQ(code("\"window\":[5.0,", "\"window\":["), "unreadable-file");
  EXPECT_EQ(code("\"section\":2", "\"section\":3"), "bad-profile");
  EXPECT_EQ(code("\"class\":1", "\"class\":1.5"), "bad-profile");
  EXPECT_EQ(code("\"area\":0.1", "\"area\":0"), "bad-profile");
  EXPECT_EQ(code("\"weight\":0.0", "\"weight\":-1"), "bad-profile");
  EXPECT_EQ(code("\"touches_border\":true", "\"touches_border\":1"), "bad-profile");
  EXPECT_EQ(code("\"contour\":[[0.1,0.0],", "\"contour\":["), "bad-profile");
  EXPECT_EQ(code("\"contour\":[[0.1,0.0]", "\"contour\":[[0.1,\"0\"]"), "bad-profile");
  EXPECT_EQ(code("\"color\":[", "\"color\":[1e300,"), "bad-profile");
}

TEST(LoadProfiles, TheNodeReadsOneJsonFile) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "a.json") << json_of(with_outlines());
  const auto run = test::run_node("LoadProfiles", {}, {{"path", (folder / "a.json").string()}});
  EXPECT_EQ(run.output<Profiles>("profiles").profiles[1].contour, with_outlines().profiles[1].contour);
  EXPECT_EQ(run.output<Profiles>("profiles").observed_area, with_outlines().observed_area);
  const auto in_micrometers = [&] {
    test::run_node("LoadProfiles", {}, {{"path", (folder / "a.json").string()}, {"unit", "um"}});
  };
  EXPECT_EQ(diagnostic_of(in_micrometers).code, "bad-value");
  std::ofstream(folder / "b.json") << json_of(with_outlines());
  EXPECT_EQ(diagnostic_of([&] {
              test::run_node("LoadProfiles", {}, {{"path", (folder / "*.json").string()}});
            }).code,
            "several-files");
}

TEST(LoadProfiles, RealTable) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const auto run = test::run_node(
      "LoadProfiles", {}, {{"path", (data / "profiles/grainsizetools_areas.txt").string()}, {"unit", "um"}});
  const auto& p = run.output<Profiles>("profiles");
  EXPECT_EQ(p.profiles.size(), 2661u);
  double sum = 0;
  for (const auto& q : p.profiles) sum += q.area;
  EXPECT_NEAR(sum, 3.229985, 1e-5);
}

}  // namespace
}  // namespace terrazzo

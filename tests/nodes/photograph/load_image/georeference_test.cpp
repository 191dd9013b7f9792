// Pictures that lie on a map: GeoTIFF by GDAL, world files, and outlines in map coordinates.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "nodes/data/table.h"
#include "runtime/files.h"
#include "tests/support/code_of.h"
#include "tests/support/picture.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::code_of;

class Georeferences : public ::testing::Test {
 protected:
  // A gray picture of 8 × 6 pixels.
  fs::path picture(const std::string& name = "a.png") {
    test::write_picture((folder / name).string(), 8, 6, 3, Sample::UInt8,
                        std::vector<std::uint8_t>(8 * 6 * 3, 90), {});
    return folder / name;
  }
  fs::path with_world(const std::string& world, const std::string& end = "pgw") {
    std::ofstream(folder / ("a." + end)) << world;
    return picture();
  }
  static test::NodeRun loaded(const fs::path& path, const std::string& pixel_size = "50",
                              std::map<std::string, std::string> more = {}) {
    more["path"] = path.string();
    more["pixel_size"] = pixel_size;
    return test::run_node("LoadImage", {}, more);
  }
  static std::string code(const fs::path& path, const std::string& pixel_size = "50") {
    return code_of([&] { loaded(path, pixel_size); });
  }
  fs::path folder = test::temporary_folder();
};

constexpr const char* kPlain = "0.05\n0\n0\n-0.05\n500000.025\n5200000.975\n";

TEST_F(Georeferences, WorldFilesNameTheCenterOfTheFirstPixel) {
  for (const char* end : {"pgw", "pngw", "wld"}) {
    const auto image = loaded(with_world(kPlain, end)).output<Image>("image");
    ASSERT_TRUE(image.georeference) << end;
    const Vec2 corner = image.georeference->on_map({0, 0}), other = image.georeference->on_map({8, 6});
    EXPECT_NEAR(corner.x(), 500000, 1e-8);
    EXPECT_NEAR(corner.y(), 5200001, 1e-8);
    EXPECT_NEAR(other.x(), 500000.4, 1e-8);
    EXPECT_NEAR(other.y(), 5200000.7, 1e-8);
    EXPECT_NEAR((image.georeference->in_picture(other) - Vec2(8, 6)).norm(), 0, 1e-6);
    fs::remove(folder / ("a." + std::string(end)));
  }
  EXPECT_FALSE(loaded(picture()).output<Image>("image").georeference);
}

TEST_F(Georeferences, SurviveTheCache) {
  const Value value = Value::of(loaded(with_world(kPlain)).output<Image>("image"));
  BufferWriter bytes;
  value.type().encode(value.data(), bytes);
  Reader reader(bytes.buffer.data(), bytes.buffer.size());
  const auto read = value.type().decode(reader);
  ASSERT_TRUE(static_cast<const Image*>(read.get())->georeference);
  EXPECT_EQ(static_cast<const Image*>(read.get())->georeference->m, value.as<Image>().georeference->m);
}

TEST_F(Georeferences, MustAgreeWithThePixelSize) {
  const fs::path path = with_world(kPlain);
  EXPECT_EQ(code(path, "1"), "contradicting-unit");
  EXPECT_EQ(code(path, "49"), "contradicting-unit");
  EXPECT_EQ(code(path, "50.01"), "");
}

TEST_F(Georeferences, TurnedPixelsAreKeptAndOthersRefused) {
  const auto image = loaded(with_world("0.03\n0.04\n0.04\n-0.03\n100\n200\n")).output<Image>("image");
  ASSERT_TRUE(image.georeference);
  EXPECT_NEAR((image.georeference->on_map({0.5, 0.5}) - Vec2(100, 200)).norm(), 0, 1e-12);
  EXPECT_NEAR((image.georeference->on_map({1.5, 0.5}) - Vec2(100.03, 200.04)).norm(), 0, 1e-12);
  for (const char* world : {"0.05\n0\n0.01\n-0.05\n0\n0\n", "0.05\n0\n0\n-0.06\n0\n0\n", "0\n0\n0\n0\n0\n0\n",
                            "0.05\n0\n0\n-0.05\n0\n", "0.05\n0\n0\n-0.05\n0\n0\n1\n",
                            "0.05\nx\n0\n-0.05\n0\n0\n", "nan\n0\n0\n-0.05\n0\n0\n", ""})
    EXPECT_EQ(code(with_world(world)), "bad-georeference") << world;
}

TEST_F(Georeferences, OfPicturesThatAreStoredTurnedAreRefused) {
  std::ofstream(folder / "a.tfw") << kPlain;
  for (const int orientation : {1, 2, 6}) {
    test::write_picture((folder / "a.tif").string(), 8, 6, 3, Sample::UInt8,
                        std::vector<std::uint8_t>(8 * 6 * 3, 90), {{"Orientation", orientation}});
    EXPECT_EQ(code(folder / "a.tif"), orientation == 1 ? "" : "bad-georeference") << orientation;
  }
  EXPECT_EQ(code_of([&] { loaded(folder / "a.tif", "50", {{"tilt", "20"}, {"field_of_view", "50"}}); }), "");
}

TEST_F(Georeferences, OfStacksAndTiltedPhotographsAreLeftOut) {
  with_world(kPlain);
  const auto tilted = loaded(folder / "a.png", "50", {{"tilt", "20"}, {"field_of_view", "50"}});
  EXPECT_FALSE(tilted.output<Image>("image").georeference);
  EXPECT_EQ(tilted.warnings.size(), 1u);
  picture("b.png");
  const auto stack = loaded(folder / "*.png", "1");
  EXPECT_FALSE(stack.output<Image>("image").georeference);
  EXPECT_EQ(stack.warnings.size(), 1u);
}

// Two labels, of 2 × 2 pixels and 1, with their picture at 50 mm.
struct Mapped {
  Image image{8, 6, 1, 50, Vec3f::Constant(0.5F)};
  Labels labels{8, 6, 1, 50, std::vector<std::int32_t>(48, 0), {0, 1}};
  Mapped() {
    image.georeference = Georeference{{0.03, 0.04, 500000, 0.04, -0.03, 5200000}, 32633};
    labels.ids[8 * 1 + 2] = labels.ids[8 * 1 + 3] = labels.ids[8 * 2 + 2] = labels.ids[8 * 2 + 3] = 1;
    labels.ids[8 * 4 + 6] = 2;
  }
  fs::path written(const std::string& name) const {
    const fs::path out = test::temporary_folder();
    test::run_node("Export", {{"labels", Value::of(labels)}, {"image", Value::of(image)}}, {{"path", name}},
                   out);
    return out / name;
  }
};

TEST(GeoreferencedOutlines, ComeBackThroughGeoJson) {
  const Mapped mapped;
  const fs::path file = mapped.written("a.geojson");
  auto json = nlohmann::json::parse(read_file(file).value());
  const auto first = json["features"][0]["geometry"]["coordinates"][0];
  double closest = INFINITY;  // the corner (2, 1) of the first label
  for (const auto& p : first)
    closest = std::min(closest, std::hypot(p[0].get<double>() - 500000.10, p[1].get<double>() - 5200000.05));
  EXPECT_LT(closest, 1e-8);
  const auto read = [&](const std::multimap<std::string, Value>& inputs) {
    return test::run_node("LoadLabels", inputs, {{"path", file.string()}}).output<Labels>("labels");
  };
  EXPECT_EQ(read({}).ids, mapped.labels.ids);
  // Without Export's own note, as from QGIS: the picture says where the map is.
  json.erase("picture");
  std::ofstream(file) << json.dump();
  EXPECT_EQ(read({{"image", Value::of(mapped.image)}}).ids, mapped.labels.ids);
  auto unnamed = json;
  unnamed["crs"]["properties"] = {1};
  std::ofstream(file) << unnamed.dump();
  EXPECT_EQ(read({{"image", Value::of(mapped.image)}}).ids, mapped.labels.ids);
  std::ofstream(file) << json.dump();
  Image elsewhere = mapped.image;
  elsewhere.georeference->epsg = 32634;
  EXPECT_EQ(code_of([&] { read({{"image", Value::of(elsewhere)}}); }), "bad-georeference");
}

TEST(GeoreferencedOutlines, TablesHaveTheCentroidOnTheMap) {
  const Mapped mapped;
  Profiles profiles;
  profiles.window = Vec2(400, 300);
  profiles.observed_area = 400 * 300;
  Profile p;
  p.area = 10000;
  p.centroid = Vec2(150, 200);  // column 3, row 2
  profiles.profiles = {p};
  const fs::path out = test::temporary_folder();
  test::run_node("Export", {{"profiles", Value::of(profiles)}, {"image", Value::of(mapped.image)}},
                 {{"path", "a.csv"}}, out);
  const auto table =
      test::run_node("LoadTable", {}, {{"path", (out / "a.csv").string()}}).output<Table>("table");
  EXPECT_NEAR(table.number(0, "map_x"), 500000 + 0.09 + 0.08, 1e-8);
  EXPECT_NEAR(table.number(0, "map_y"), 5200000 + 0.12 - 0.06, 1e-8);
}

TEST(GeoreferencedOutlines, GdalWritesPicturesAndReadsOutlines) {
  if (!test::has_python_module("osgeo.gdal")) GTEST_SKIP() << "python3-gdal is not installed";
  const fs::path folder = test::temporary_folder();
  const auto written = [&](const char* transform, const char* epsg, const char* kind) {
    const fs::path file = folder / "a.tif";
    fs::remove(file);
    test::run_reader("georeference.py", {"write", file.string(), transform, epsg, kind});
    return test::run_node("LoadImage", {}, {{"path", file.string()}, {"pixel_size", "50"}});
  };
  for (const char* kind : {"Area", "Point"}) {  // GDAL's transform is that of the corner for both
    const auto g =
        written("500000,0.05,0,5200000,0,-0.05", "32633", kind).output<Image>("image").georeference;
    ASSERT_TRUE(g) << kind;
    EXPECT_EQ(g->epsg, 32633);
    EXPECT_NEAR((g->on_map({8, 6}) - Vec2(500000.4, 5199999.7)).norm(), 0, 1e-8) << kind;
  }
  const auto turned = written("500000,0.03,0.04,5200000,0.04,-0.03", "32633", "Area").output<Image>("image");
  ASSERT_TRUE(turned.georeference);
  EXPECT_NEAR((turned.georeference->on_map({1, 0}) - Vec2(500000.03, 5200000.04)).norm(), 0, 1e-8);
  const auto degrees = written("15,1e-6,0,47,0,-1e-6", "4326", "Area");
  EXPECT_FALSE(degrees.output<Image>("image").georeference);
  EXPECT_EQ(degrees.warnings.size(), 1u);
  EXPECT_EQ(code_of([&] { written("500000,0.05,0.01,5200000,0,-0.05", "32633", "Area"); }),
            "bad-georeference");
  EXPECT_EQ(code_of([&] { written("500000,0.1,0,5200000,0,-0.1", "32633", "Area"); }), "contradicting-unit");

  const auto j = test::run_reader("georeference.py", {"read", Mapped().written("a.geojson").string()});
  EXPECT_EQ(j["epsg"], 32633);
  EXPECT_EQ(j["valid"], true);
  ASSERT_EQ(j["areas"].size(), 2u);
  EXPECT_NEAR(j["areas"][0], 4 * 0.05 * 0.05, 1e-9);  // m²
  EXPECT_NEAR(j["areas"][1], 0.05 * 0.05, 1e-9);
}

}  // namespace
}  // namespace terrazzo

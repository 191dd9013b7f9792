// Bytes that are not UTF-8: an error with a position in graphs, Windows-1252 or replaced in data. They never
// end a run.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "graph/text/utf8.h"
#include "runtime/files.h"
#include "tests/runtime/clients/studio/paint_picture.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::run_program;

class ForeignBytes : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }
  test::ProgramRun run(const fs::path& graph, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"run",        graph.string(), "--out",
                                          out.string(), "--cache",      (folder / "cache").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  // The report of a run. Throws if it is not valid JSON, and so not UTF-8.
  json report() const { return json::parse(read_file(out / "report.json").value_or("no report")); }

  const fs::path folder = test::temporary_folder();
  fs::path out = folder / "out";
};

TEST(Utf8, FindsAndReplacesWhatIsNone) {
  for (const char* good : {"", "a", "µ", "€", "𝄞", "\xef\xbb\xbf", "\xf4\x8f\xbf\xbf"})
    EXPECT_EQ(find_invalid_utf8(good), std::string::npos) << good;
  for (const char* bad : {"\xe9", "\xc3", "\xc0\xaf", "\xe0\x80\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80",
                          "\xf8\x88\x80\x80\x80", "\x80", "\xe2\x82"}) {
    EXPECT_EQ(find_invalid_utf8(std::string("ab") + bad), 2u);
    EXPECT_EQ(find_invalid_utf8(valid_utf8(bad)), std::string::npos);
  }
  EXPECT_EQ(valid_utf8("gr\xfcn, \xe9t\xe9"), "gr\uFFFDn, \uFFFDt\uFFFD");
}

TEST_F(ForeignBytes, InAGraphAreAnErrorAtTheirPlace) {
  const auto r = run(write("bad.yaml", "terrazzo: 1\nnodes:\n  µ caf\xe9: {type: Pattern}\n"));
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("bad.yaml:3:8: error: the byte 0xe9 is not UTF-8 (save the file as UTF-8)"),
            std::string::npos)
      << r.err;
  const auto good = write("good.yaml", "terrazzo: 1\nnodes: {pattern: {type: Pattern}}\n");
  for (const char* option : {"--set", "--param"}) {
    const auto set = run(good, {option, "pattern.kind=fl\xe4"});
    EXPECT_EQ(set.exit_code, 2);
    EXPECT_NE(set.err.find("is not UTF-8"), std::string::npos) << set.err;
  }
  EXPECT_EQ(
      run_program({"sweep", good.string(), "--vary", "pattern.kind=fl\xe4", "--out", out.string()}).exit_code,
      2);
}

TEST_F(ForeignBytes, InATableAreReadAsLatin1WithAWarning) {
  write("grains.csv", "Area (\xb5m\xb2),Mineral\n12.5,gr\xfcn\n9,quartz\n");
  const auto r = run(write("grains.yaml", R"(terrazzo: 1
nodes:
  grains: {type: LoadProfiles, params: {path: grains.csv, unit: µm}}
  table: {type: Export, inputs: {profiles: grains.profiles}, params: {path: grains.json}}
)"));
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("'grains.csv' is not UTF-8"), std::string::npos) << r.err;
  EXPECT_NE(report().at("nodes").dump().find("'grains.csv' is not UTF-8"), std::string::npos);
}

// The error quotes the wrong cell; the node fails, but the report is still written.
TEST_F(ForeignBytes, InAnErrorLeaveTheReport) {
  write("grains.csv", "area,class\n12.5,gr\xfcn\n");
  const auto r = run(write("grains.yaml", R"(terrazzo: 1
nodes:
  other: {type: Pattern, params: {kind: fat, width: 16, height: 16}}
  file: {type: Export, inputs: {image: other.image}, params: {path: other.png}}
  grains: {type: LoadProfiles, params: {path: grains.csv}}
)"));
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_TRUE(fs::exists(out / "other.png"));
  EXPECT_NE(report().at("nodes").dump().find("grün"), std::string::npos);
}

// Names of files and folders need not be UTF-8.
TEST_F(ForeignBytes, InNamesOfFilesHarmNothing) {
  const fs::path work = folder / "\xe9tude";
  fs::create_directories(work);
  fs::copy(test::paint_picture(), work / "caf\xe9.png");
  std::ofstream(work / "t\xeatra.obj")
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  std::ofstream(work / "\xfc.yaml") << R"(terrazzo: 1
nodes:
  picture: {type: LoadImage, params: {path: '*.png'}}
  copy: {type: Export, inputs: {image: picture.image}, params: {path: copy.png}}
  mesh: {type: LoadMesh, params: {path: '*.obj'}}
  solid: {type: Export, inputs: {shapes: mesh.shapes}, params: {path: solid.glb}}
)";
  out = folder / "sorti\xe9";
  for (const char* round : {"computed", "disk"}) {
    const auto r = run(work / "\xfc.yaml");
    EXPECT_EQ(r.exit_code, 0) << round << r.err;
    EXPECT_TRUE(fs::exists(out / "solid.glb") && fs::exists(out / "copy.png"));
    const json told = report();
    for (const auto& node : told.at("nodes")) EXPECT_EQ(node.at("status"), round) << node.at("name");
    EXPECT_NE(told.dump().find("its shape is called t\uFFFDtra"), std::string::npos);
  }
  const auto shown =
      run_program({"show", (work / "\xfc.yaml").string(), "mesh.shapes", "--json", "--no-cache"});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_NE(shown.out.find("t\uFFFDtra"), std::string::npos) << shown.out;
  const auto swept = run_program({"sweep", (work / "\xfc.yaml").string(), "--vary", "mesh.scale=1,2",
                                  "--preview", "copy.png", "--no-cache", "--out", out.string()});
  EXPECT_EQ(swept.exit_code, 0) << swept.err;
  EXPECT_TRUE(fs::exists(out / "sweep.png")) << swept.err;
}

}  // namespace
}  // namespace terrazzo

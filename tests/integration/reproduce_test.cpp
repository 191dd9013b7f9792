// Files record how they were made and can be reproduced. Every value can be written to a file.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "runtime/files.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::run_program;

class Reproduce : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::copy_file(test::source_folder() / "graphs/samples/section.png", folder / "photo.png");
    std::ofstream(folder / "graph.yaml") << R"(terrazzo: 1
parameters: {kind: {type: text, default: box}}
nodes:
  photo: {type: LoadImage, params: {path: photo.png}}
  shape: {type: Shape, params: {kind: "${kind}"}}
  sizes: {type: Distribution, params: {mean: 1, sd: 0.1, volume_fraction: 0.2}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {count: 30}}
  voxels: {type: Voxelize, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {resolution: 16}}
  glb: {type: Export, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {path: deep/pack.glb}}
  vdb: {type: Export, inputs: {volume: voxels.volume}, params: {path: grids.vdb}}
  png: {type: Export, inputs: {image: photo.image}, params: {path: copy.png}}
  csv: {type: Export, inputs: {particles: pack.particles}, params: {path: deep/pack.csv}}
)";
    const auto r =
        run_program({"run", (folder / "graph.yaml").string(), "--out", (folder / "out").string(), "--cache",
                     (folder / "cache").string(), "--param", "kind=tetrahedron", "--set", "pack.seed=7"});
    ASSERT_EQ(r.exit_code, 0) << r.err;
  }
  fs::path folder = test::temporary_folder();
};

TEST_F(Reproduce, EveryFormatTellsHowItWasMade) {
  for (const char* file : {"deep/pack.glb", "grids.vdb", "copy.png", "deep/pack.csv", "report.json"}) {
    const fs::path again = folder / "again";
    fs::remove_all(again);
    const auto r = run_program({"reproduce", (folder / "out" / file).string(), "--yes", "--out",
                                again.string(), "--cache", (folder / "cache").string()});
    EXPECT_EQ(r.exit_code, 0) << file << ": " << r.err;
    EXPECT_EQ(r.out.find("different action key"), std::string::npos) << r.out;
    EXPECT_NE(r.out.find("have the same action key as in the original run"), std::string::npos) << r.out;
    if (std::string(file) != "report.json") {
      EXPECT_TRUE(fs::exists(again / file)) << r.out;
    }
    // The written graph is self-contained and includes the overrides.
    const auto graph = read_file(again / (fs::path(file).stem().string() + ".yaml"));
    ASSERT_TRUE(graph) << file;
    if (std::string(file) != "copy.png") {
      EXPECT_NE(graph->find("kind: \"tetrahedron\""), std::string::npos) << *graph;
      EXPECT_NE(graph->find("seed: 7"), std::string::npos) << *graph;
    }
  }
}

TEST_F(Reproduce, WhatChangedSinceThenIsSaid) {
  fs::copy_file(folder / "out" / "grids.vdb", folder / "photo.png", fs::copy_options::overwrite_existing);
  const std::vector<std::string> again = {
      "reproduce", (folder / "out" / "copy.png").string(), "--yes", "--out", (folder / "again").string(),
      "--no-cache"};
  const auto refused = run_program(again);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.out.find("photo.png, which is NOT the file it was made from"), std::string::npos)
      << refused.out;
  auto granted = again;
  granted.insert(granted.end(), {"--allow-read", folder.string()});
  const auto other = run_program(granted);
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.out.find("photo has a different action key"), std::string::npos) << other.out;
  fs::remove(folder / "photo.png");
  const auto gone = run_program(again);
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_NE(gone.err.find("there is no file"), std::string::npos) << gone.err;
}

TEST_F(Reproduce, AFileOfSomebodyElseIsRefused) {
  std::ofstream(folder / "other.csv") << "a,b\n1,2\n";
  for (const fs::path& file : {folder / "other.csv", folder / "nothing.png"}) {
    const auto r = run_program({"reproduce", file.string(), "--no-cache"});
    EXPECT_EQ(r.exit_code, 2) << r.err;
    EXPECT_NE(r.err.find(file.string()), std::string::npos) << r.err;
  }
}

TEST_F(Reproduce, AsksBeforeItRunsAnything) {
  const auto r = run_program({"reproduce", (folder / "out" / "copy.png").string(), "--out",
                              (folder / "again").string(), "--no-cache"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("--yes"), std::string::npos) << r.err;
  EXPECT_FALSE(fs::exists(folder / "again"));
  // It shows the graph, the files it would read and the files it would write.
  for (const std::string& part : {std::string("type: LoadImage"), "reads  " + (folder / "photo.png").string(),
                                  "writes " + (folder / "again" / "copy.png").string(),
                                  "writes " + (folder / "again" / "copy.yaml").string()})
    EXPECT_NE(r.out.find(part), std::string::npos) << part << " in " << r.out;
}

// A report from an untrusted source.
class StrangersFile : public Reproduce {
 protected:
  test::ProgramRun reproduce(const std::string& nodes, std::vector<std::string> more = {}) {
    const nlohmann::json report = {{"document", "terrazzo: 1\nnodes:\n" + nodes},
                                   {"nodes", nlohmann::json::array()}};
    fs::create_directories(folder / "mail");
    std::ofstream(folder / "mail" / "report.json") << report.dump();
    std::vector<std::string> arguments = {"reproduce",
                                          (folder / "mail" / "report.json").string(),
                                          "--yes",
                                          "--out",
                                          (folder / "again").string(),
                                          "--no-cache"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
};

TEST_F(StrangersFile, ReadsNothingThatItCannotNameByContent) {
  fs::create_directories(folder / "private");
  fs::copy_file(folder / "photo.png", folder / "private" / "secret.png");
  const std::string nodes =
      "  p: {type: LoadImage, params: {path: '" + (folder / "private").string() +
      "/*.png'}}\n  w: {type: Export, inputs: {image: p.image}, params: {path: stolen.png}}\n";
  const auto refused = reproduce(nodes);
  EXPECT_EQ(refused.exit_code, 2) << refused.err;
  EXPECT_NE(refused.out.find("secret.png, which is NOT"), std::string::npos) << refused.out;
  EXPECT_FALSE(fs::exists(folder / "again"));
  EXPECT_EQ(reproduce(nodes, {"--allow-read", (folder / "mail").string()}).exit_code, 2);
  fs::create_directory_symlink(folder / "private",
                               folder / "mail" / "link");  // does not extend the granted access
  const std::string through =
      "  p: {type: LoadImage, params: {path: '" + (folder / "mail" / "link").string() +
      "/secret.png'}}\n  w: {type: Export, inputs: {image: p.image}, params: {path: x.png}}\n";
  EXPECT_EQ(reproduce(through, {"--allow-read", (folder / "mail").string()}).exit_code, 2);
  EXPECT_FALSE(fs::exists(folder / "again"));
  const auto granted = reproduce(nodes, {"--allow-read", (folder / "private").string()});
  EXPECT_EQ(granted.exit_code, 0) << granted.err;
  EXPECT_TRUE(fs::exists(folder / "again" / "stolen.png"));
}

TEST_F(StrangersFile, WritesNothingOutsideTheOutputFolder) {
  for (const std::string& path : {std::string("../x.obj"), (folder / "x.obj").string()}) {
    const auto r =
        reproduce("  s: {type: Shape}\n  w: {type: Export, inputs: {shapes: s.shapes}, params: {path: '" +
                  path + "'}}\n");
    EXPECT_EQ(r.exit_code, 2) << r.err;
    EXPECT_NE(r.err.find("outside the output folder"), std::string::npos) << r.err;
  }
  EXPECT_FALSE(fs::exists(folder / "x.obj"));
}

TEST_F(StrangersFile, LoadsNoPlugins) {
  std::ofstream(folder / "not-a-plugin.so") << "x";
  const std::string plugins = "TERRAZZO_PLUGIN_PATH=" + (folder / "not-a-plugin.so").string();
  // Other commands try to load the plugin and report the failure.
  const auto check = run_program({"check", (folder / "graph.yaml").string()}, {.environment = plugins});
  EXPECT_NE(check.err.find("not-a-plugin.so"), std::string::npos) << check.err;
  const auto r = run_program({"reproduce", (folder / "out" / "copy.png").string(), "--yes", "--no-cache",
                              "--out", (folder / "again").string()},
                             {.environment = plugins});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.err.find("not-a-plugin.so"), std::string::npos) << r.err;
}

TEST_F(StrangersFile, OpensNoOtherGraph) {
  std::ofstream(folder / "private.yaml") << "terrazzo: 1\nnodes:\n  secret: {type: Shape}\n";
  const auto r = reproduce("  g: {graph: '" + (folder / "private.yaml").string() + "'}\n");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("refers to another graph file"), std::string::npos) << r.err;
}

TEST_F(Reproduce, ShowWritesAnyValue) {
  for (const auto& [output, file] : {std::pair{"pack.particles", "p.glb"},
                                     {"pack.particles", "p.usda"},
                                     {"pack.particles", "p.xml"},
                                     {"pack.particles", "p.pbrt"},
                                     {"pack.particles", "p.csv"},
                                     {"voxels.volume", "v.vdb"},
                                     {"shape.shapes", "s.obj"},
                                     {"photo.image", "i.exr"}}) {
    const auto r = run_program({"show", (folder / "graph.yaml").string(), output, "-o",
                                (folder / file).string(), "--cache", (folder / "cache").string()});
    EXPECT_EQ(r.exit_code, 0) << output << ": " << r.err;
    EXPECT_TRUE(fs::exists(folder / file) && fs::file_size(folder / file) > 100) << file;
  }
  const auto wrong = run_program({"show", (folder / "graph.yaml").string(), "photo.image", "-o",
                                  (folder / "x.glb").string(), "--no-cache"});
  EXPECT_EQ(wrong.exit_code, 1);
}

TEST_F(Reproduce, ASweepSharesWhatIsCommonAndGoesOn) {
  const std::vector<std::string> sweep = {"sweep",     (folder / "graph.yaml").string(),
                                          "--vary",    "pack.seed=1:3:1",
                                          "--vary",    "kind=box,octahedron",
                                          "--out",     (folder / "sweep").string(),
                                          "--cache",   (folder / "cache").string(),
                                          "--preview", "copy.png",
                                          "--jobs",    "2"};
  const auto first = run_program(sweep);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  std::map<std::string, int> computed;  // by action key
  for (int i = 1; i <= 6; ++i) {
    const auto text = read_file(folder / "sweep" / ("point-00" + std::to_string(i)) / "report.json");
    ASSERT_TRUE(text);
    const auto report = nlohmann::json::parse(*text);
    for (const auto& node : report.at("nodes"))
      if (node.at("status") == "computed" && !node.at("outputs").empty()) ++computed[node.at("key")];
  }
  for (const auto& [key, times] : computed) EXPECT_EQ(times, 1) << key;
  EXPECT_EQ(computed.size(),
            2u + 6 + 6);  // the shapes; pack and voxels of each sweep point
  const auto table = read_file(folder / "sweep" / "sweep.csv").value_or("");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 7);
  EXPECT_EQ(table.rfind("point,pack.seed,kind,status,seconds,", 0), 0u) << table;
  EXPECT_TRUE(fs::exists(folder / "sweep" / "sweep.png"));
  const auto second = run_program(sweep);
  EXPECT_EQ(second.out.find(" 1 computed"), std::string::npos) << second.out;
  EXPECT_NE(second.out.find(": 0 computed"), std::string::npos) << second.out;
  const auto wrong = run_program({"sweep", (folder / "graph.yaml").string(), "--vary", "pack.sead=1,2"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("did you mean 'seed'"), std::string::npos) << wrong.err;
}

}  // namespace
}  // namespace terrazzo

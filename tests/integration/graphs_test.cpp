// Checks that every shipped graph loads without errors and that the default graph does what the README says.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "graph/graph.h"
#include "runtime/files.h"
#include "tests/support/all_nodes.h"
#include "tests/support/program.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using test::run_program;
using Names = std::set<std::string>;

// What `terrazzo check` checks, without a start of the program for each graph.
TEST(Graphs, AllAreFreeOfMistakes) {
  int graphs = 0;
  for (const auto& e : fs::recursive_directory_iterator(test::source_folder() / "graphs")) {
    if (e.path().extension() != ".yaml") continue;
    ++graphs;
    Diagnostics found;
    const Graph graph = load_graph(e.path(), test::all_nodes(), {}, found);
    for (const auto& d : found)
      if (d.severity == Severity::Error) ADD_FAILURE() << d.text();
    for (const auto& node : graph.nodes)
      for (const auto& p : node.type->parameters) {
        const auto it = node.parameters.find(p.name);
        if (p.kind != ParameterKind::InputPath || it == node.parameters.end()) continue;
        const auto& path = std::get<std::string>(it->second.value);
        EXPECT_FALSE(expand_glob(path).empty()) << e.path() << ": there is no file " << path;
      }
  }
  EXPECT_GE(graphs, 4);
  const auto checked =
      run_program({"check", (test::source_folder() / "graphs/materials/terrazzo.yaml").string()});
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
}

// Routes that were not asked for may fail, and write nothing.
TEST(Graphs, AMaterialComesFromTheRouteThatWasAskedFor) {
  const fs::path out = test::temporary_folder();
  const auto r =
      run_program({"run", (test::source_folder() / "graphs/library/material.yaml").string(), "--no-cache",
                   "--out", out.string(), "--param", "route=exemplar", "--param", "resolution=16", "--set",
                   "exemplar/solid.exemplar_size=64", "--set", "exemplar/block.samples=1", "--set",
                   "exemplar/block.width=64", "--set", "exemplar/block.height=64"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("warning: particles/route.asked: 'exemplar' was asked for"), std::string::npos)
      << r.err;
  for (const char* file : {"routes.csv", "view.png", "preview.png", "contact_sheet.png", "material.vdb"})
    EXPECT_TRUE(fs::exists(out / file)) << file;
  EXPECT_FALSE(fs::exists(out / "material.glb"));
  std::string header, phases, particles, exemplar;
  std::ifstream table(out / "routes.csv");
  for (std::string* line : {&header, &phases, &particles, &exemplar}) std::getline(table, *line);
  EXPECT_EQ(phases.find("phases,no"), 0u);
  EXPECT_EQ(particles.find("particles,no"), 0u);
  EXPECT_EQ(exemplar.find("exemplar,yes"), 0u);
}

// The default graph at a small size.
class DefaultGraph : public ::testing::Test {
 protected:
  static json run(std::vector<std::string> more, const fs::path& cache, int threads = 0) {
    std::vector<std::string> arguments = {"run",
                                          (test::source_folder() / "graphs/materials/terrazzo.yaml").string(),
                                          "--cache",
                                          cache.string(),
                                          "--out",
                                          (folder() / "out").string(),
                                          "--report",
                                          (folder() / "report.json").string(),
                                          "--quiet",
                                          "--threads",
                                          std::to_string(threads),
                                          "--param",
                                          "size=22",
                                          "--param",
                                          "resolution=40",
                                          "--set",
                                          "detail.size=32",
                                          "--set",
                                          "shape.rounds=1",
                                          "--set",
                                          "section.width=28",
                                          "--set",
                                          "section.height=28",
                                          "--set",
                                          "block.samples=2",
                                          "--set",
                                          "block.width=96",
                                          "--set",
                                          "block.height=96"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto r = run_program(arguments);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return json::parse(std::ifstream(folder() / "report.json"));
  }
  static Names with_status(const json& report, const std::string& status) {
    Names out;
    for (const auto& n : report.at("nodes"))
      if (n.at("status") == status) out.insert(n.at("name").get<std::string>());
    return out;
  }
  static std::map<std::string, json> contents(const json& report) {
    std::map<std::string, json> out;
    for (const auto& n : report.at("nodes"))
      for (const auto& [port, o] : n.at("outputs").items())
        out[n.at("name").get<std::string>() + "." + port] = o.at("content");
    return out;
  }
  static double metric(const json& report, const std::string& node, const std::string& name) {
    for (const auto& n : report.at("nodes"))
      if (n.at("name") == node) return n.at("metrics").at(name);
    ADD_FAILURE() << "no node " << node;
    return 0;
  }
  static const fs::path& folder() {  // of all tests
    static const fs::path made = test::temporary_folder();
    return made;
  }
  static fs::path cache() { return folder() / "cache"; }
  // The report of the first run, which computes everything. Tests of one program share it.
  static const json& first() {
    static const json report = run({}, cache(), 3);
    return report;
  }
};

TEST_F(DefaultGraph, ComputesOnceAndThenExactlyWhatAnEditTouches) {
  EXPECT_EQ(with_status(first(), "computed").size(), first().at("nodes").size());
  for (const auto* file :
       {"terrazzo.glb", "terrazzo.vdb", "preview.png", "contact_sheet.png", "comparison.csv"})
    EXPECT_TRUE(fs::exists(folder() / "out" / file)) << file;
  const double ratio = metric(first(), "compare", "area_fraction_ratio");
  EXPECT_NEAR(ratio, 1, 0.1);
  EXPECT_LE(metric(first(), "pack", "max_penetration"), 1e-4);

  const json again = run({}, cache());
  EXPECT_EQ(with_status(again, "computed"), Names{});

  const json colored = run({"--set", "colorize.seed=2"}, cache());
  EXPECT_EQ(with_status(colored, "computed"),
            (Names{"colorize", "voxels", "sections", "compare", "section", "observer", "block", "sheet",
                   "instances", "grids", "section_image", "observers", "observers_figure", "preview",
                   "contact_sheet", "comparison", "comparison_figure"}));
  // After reverting, everything is a cache hit and only the files are written again.
  const json back = run({}, cache());
  EXPECT_EQ(with_status(back, "computed"),
            (Names{"instances", "grids", "section_image", "observers", "observers_figure", "preview",
                   "contact_sheet", "comparison", "comparison_figure"}));
  EXPECT_EQ(contents(back), contents(first()));
}

TEST_F(DefaultGraph, HasEqualContentOnAnyNumberOfThreads) {
  const auto several = contents(first());  // before the other run writes its report
  EXPECT_EQ(contents(run({}, folder() / "one", 1)), several);
}

}  // namespace
}  // namespace terrazzo

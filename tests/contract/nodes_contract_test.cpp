// The contract that every registered node must keep.
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/kmatrix.h"
#include "nodes/data/labels.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/data/strokes.h"
#include "nodes/data/table.h"
#include "nodes/media/annealing/media_base.h"
#include "nodes/solids/synthesis/solid_base.h"
#include "runtime/compute_node.h"
#include "runtime/evaluate.h"
#include "tests/contract/contents.h"
#include "tests/support/all_nodes.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

fs::path folder(const NodeType& t) { return test::node_folder(t.name); }

// A cache folder for results of so many threads, which lasts as long as the process. Examples share many
// nodes, and three of the tests below run each example.
const fs::path& cache_of(int threads) {
  static std::map<int, fs::path> folders;
  fs::path& folder = folders[threads];
  if (folder.empty()) folder = test::temporary_folder() / "cache";
  return folder;
}

class EveryNode : public ::testing::TestWithParam<std::string> {
 protected:
  const NodeType& type() const { return *test::all_nodes().find(GetParam()); }
};

TEST_P(EveryNode, IsDocumentedAtItsDoor) {
  EXPECT_TRUE(fs::exists(folder(type()) / "README.md")) << folder(type());
  EXPECT_TRUE(fs::exists(folder(type()) / "example.yaml")) << folder(type());
  for (const auto& p : type().parameters) {
    EXPECT_TRUE(p.kind != ParameterKind::Choice || !p.choices.empty()) << p.name;
  }
}

TEST_P(EveryNode, EveryParameterIsInTheKey) {
  GraphNode node;
  node.type = &type();
  const Hash plain = action_key(node, {}, {});
  for (const auto& p : type().parameters) {
    GraphNode changed = node;
    changed.parameters[p.name] = {ParameterValue(std::string("another value altogether")), {}, {}};
    EXPECT_NE(action_key(changed, {}, {}), plain) << p.name;
    if (!p.value) continue;
    GraphNode same = node;
    same.parameters[p.name] = {*p.value, {}, {}};
    EXPECT_EQ(action_key(same, {}, {}), plain)
        << p.name << ": writing out the default changes the action key";
  }
}

TEST_P(EveryNode, ACancelledRunComputesNothing) {
  std::atomic<bool> cancel{true};
  ComputeRequest request;
  request.type = &type();
  request.work = Work(&cancel, nullptr);
  EXPECT_THROW(compute_node(std::move(request)), Cancelled);
}

// The node's example runs, produces equal content with 1, 2 and 7 threads, and its values survive a round
// trip through the disk cache.
TEST_P(EveryNode, ItsExampleRunsTheSameOnAnyNumberOfThreads) {
  Diagnostics found;
  const fs::path file = folder(type()) / "example.yaml";
  const Graph g = load_graph(file, test::all_nodes(), {}, found);
  for (const auto& d : found) ADD_FAILURE() << d.text();
  if (has_errors(found)) return;
  bool uses = false;
  for (const auto& n : g.nodes) uses |= n.type == &type();
  EXPECT_TRUE(uses) << file << " does not use " << GetParam();
  const fs::path base = test::temporary_folder();
  static std::set<std::pair<int, Hash>> read_back;  // by threads and content
  std::vector<RunResult> runs;
  for (const int threads : {1, 2, 7}) {
    const fs::path& cache = cache_of(threads);
    Store store(test::value_types(), cache);
    FileHashes hashes;
    Evaluator e(test::value_types(), store, hashes);
    RunOptions o;
    o.threads = threads;
    o.output_folder = base / ("out" + std::to_string(threads));
    runs.push_back(e.run(g, o));
    for (const auto& n : runs.back().nodes)
      if (n.error) ADD_FAILURE() << n.error->text();
    if (runs.back().failed()) return;
    Store again(test::value_types(), cache);
    for (const auto& n : runs.back().nodes)
      for (const auto& [port, record] : n.outputs) {
        if (!read_back.emplace(threads, record.content).second) continue;
        const Value v = again.get_value(record);
        ASSERT_TRUE(v) << port << " cannot be read back";
        EXPECT_EQ(again.put_value(v).content, record.content) << port << " changes when read back";
      }
  }
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    for (const auto& r : runs) EXPECT_EQ(runs[0].nodes[i].outputs, r.nodes[i].outputs) << g.nodes[i].path;
}

// The node's example gives the contents recorded for its version.
TEST_P(EveryNode, GivesTheRecordedContents) {
  using nlohmann::json;
  const json all = test::read_contents(), machine = test::this_machine();
  const json* known = test::contents_on(all, machine);
  if (!known) GTEST_SKIP() << "no contents are recorded for " << machine.dump() << "; run ./dev contents";
  if (!known->contains(GetParam()))
    GTEST_SKIP() << "no contents are recorded for this node; run ./dev contents";
  const json now = test::example_contents(test::all_nodes(), type(), 2, cache_of(2));
  ASSERT_FALSE(now.empty()) << "the example does not use its node";
  EXPECT_EQ(test::compare_contents(GetParam(), known->at(GetParam()), now), "");
}

// An empty value of each type.
Value empty_value(const std::string& type) {
  static const std::map<std::string, Value> values = {
      {"Image", Value::of(Image{})},         {"Labels", Value::of(Labels{})},
      {"Profiles", Value::of(Profiles{})},   {"Shapes", Value::of(Shapes{})},
      {"KMatrix", Value::of(KMatrix{})},     {"SizeDistribution", Value::of(SizeDistribution{})},
      {"Table", Value::of(Table{})},         {"Particles", Value::of(Particles{})},
      {"Volume", Value::of(Volume{})},       {"Strokes", Value::of(Strokes{})},
      {"SolidBase", Value::of(SolidBase{})}, {"Detail", Value::of(Detail{})},
      {"MediaBase", Value::of(MediaBase{})}};
  const auto it = values.find(type);
  return it == values.end() ? Value() : it->second;
}

// Empties each input in turn, with the others as in the example. The node must return a result or an error
// with a message, and never crash or leak an exception of a library.
TEST_P(EveryNode, SurvivesEmptyInputs) {
  Diagnostics found;
  const Graph g = load_graph(folder(type()) / "example.yaml", test::all_nodes(), {}, found);
  ASSERT_FALSE(has_errors(found));
  const fs::path base = test::temporary_folder();
  Store store(test::value_types(), cache_of(2));
  FileHashes hashes;
  Evaluator evaluator(test::value_types(), store, hashes);
  RunOptions o;
  o.threads = 2;
  o.output_folder = base / "out";
  const RunResult result = evaluator.run(g, o);
  for (const auto& node : g.nodes) {
    if (node.type != &type()) continue;
    for (const auto& [emptied, unused] : node.inputs) {
      ComputeRequest request;
      request.type = node.type;
      std::map<std::string, ParameterValue> written;
      for (const auto& [name, p] : node.parameters) written[name] = p.value;
      request.parameters = effective_parameters(*node.type, written);
      request.output_folder = base / "empty";
      request.files = input_files(node, hashes).paths;
      for (const auto& [port, wires] : node.inputs)
        for (const auto& w : wires) {
          const Value v = evaluator.value(g, result, w);
          request.inputs[port].push_back(port == emptied ? empty_value(v.type().name) : v);
          ASSERT_TRUE(request.inputs[port].back()) << "this test has no empty " << v.type().name;
        }
      try {
        compute_node(std::move(request));
      } catch (const Error& e) {
        EXPECT_NE(e.diagnostic().code, "failed") << node.path << " without " << emptied << ": " << e.what();
        EXPECT_NE(e.diagnostic().code, "node-bug") << node.path << " without " << emptied << ": " << e.what();
        EXPECT_GT(e.diagnostic().message.size(), 10u) << emptied;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Contract, EveryNode, ::testing::ValuesIn(test::all_nodes().names()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace terrazzo

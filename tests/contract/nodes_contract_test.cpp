// What every registered node keeps, whoever wrote it.
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "nodes/register_nodes.h"
#include "runtime/compute_node.h"
#include "runtime/evaluate.h"
#include "tests/support/arithmetic.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

const Registry& registry() {
  static const Registry r = [] {
    Registry x;
    register_nodes(x);
    return x;
  }();
  return r;
}

// ShapeEstimate → shape_estimate
std::string folder_of(const std::string& type) {
  std::string out;
  for (std::size_t i = 0; i < type.size(); ++i) {
    if (i && std::isupper(static_cast<unsigned char>(type[i])) &&
        !std::isupper(static_cast<unsigned char>(type[i - 1])))
      out += '_';
    out += static_cast<char>(std::tolower(static_cast<unsigned char>(type[i])));
  }
  return out;
}

fs::path folder(const NodeType& t) {
  std::string name = folder_of(t.name);
  if (t.name == "KMatrix") name = "kmatrix";
  return fs::path(TERRAZZO_SOURCE) / "nodes" / name;
}

class EveryNode : public ::testing::TestWithParam<std::string> {
 protected:
  const NodeType& type() const { return *registry().find(GetParam()); }
};

TEST_P(EveryNode, IsDocumentedAtItsDoor) {
  EXPECT_TRUE(fs::exists(folder(type()) / "README.md")) << folder(type());
  EXPECT_TRUE(fs::exists(folder(type()) / "example.yaml")) << folder(type());
  for (const auto& p : type().parameters) {
    const bool numeric = p.kind == ParameterKind::Int || p.kind == ParameterKind::Number;
    EXPECT_TRUE(!numeric || std::isfinite(p.min) || std::isfinite(p.max)) << p.name << " has no range";
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
    EXPECT_EQ(action_key(same, {}, {}), plain) << p.name << ": a default written out changes the key";
  }
}

TEST_P(EveryNode, ACancelledRunComputesNothing) {
  std::atomic<bool> cancel{true};
  ComputeRequest request;
  request.type = &type();
  request.work = Work(&cancel, nullptr);
  EXPECT_THROW(compute_node(std::move(request)), Cancelled);
}

// The example beside the node runs, gives equal content at 1 and 3 threads, and its values survive the disk.
TEST_P(EveryNode, ItsExampleRunsTheSameOnAnyNumberOfThreads) {
  Diagnostics found;
  const fs::path file = folder(type()) / "example.yaml";
  const Graph g = load_graph(file, registry(), {}, found);
  for (const auto& d : found) ADD_FAILURE() << d.text();
  if (has_errors(found)) return;
  bool uses = false;
  for (const auto& n : g.nodes) uses |= n.type == &type();
  EXPECT_TRUE(uses) << file << " does not use " << GetParam();
  const fs::path base = test::temporary_folder();
  std::vector<RunResult> runs;
  for (const int threads : {1, 3}) {
    const fs::path cache = base / ("cache" + std::to_string(threads));
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
        const Value v = again.get_value(record);
        ASSERT_TRUE(v) << port << " cannot be read back";
        EXPECT_EQ(again.put_value(v).content, record.content) << port << " changes when read back";
      }
  }
  for (std::size_t i = 0; i < g.nodes.size(); ++i)
    EXPECT_EQ(runs[0].nodes[i].outputs, runs[1].nodes[i].outputs) << g.nodes[i].path;
}

INSTANTIATE_TEST_SUITE_P(Contract, EveryNode, ::testing::ValuesIn(registry().names()),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace terrazzo

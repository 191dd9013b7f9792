#include "runtime/report/graph_parts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "runtime/run_result.h"
#include "tests/support/arithmetic.h"

namespace terrazzo {
namespace {

using test::graph_of;

// "shared | part: target target; part: target", one line per round.
std::string rounds_of(const Graph& g, const std::vector<std::string>& targets = {}) {
  std::string out;
  for (const auto& round : graph_rounds(g, targets.empty() ? g.sinks() : target_nodes(g, targets))) {
    for (const auto& s : round.shared) out += s + " ";
    out += "|";
    for (const auto& part : round.parts) {
      out += " " + part.name + ":";
      for (const auto& t : part.targets) out += " " + t;
      out += ";";
    }
    out += "\n";
  }
  return out;
}

TEST(GraphParts, AGraphWithoutRepeatedNodesHasNone) {
  EXPECT_EQ(rounds_of(graph_of("nodes:\n  a: {type: Constant}\n  b: {type: Clamp, inputs: {in: a.out}}\n")),
            "");
}

TEST(GraphParts, ElementsAreComputedApartAndWhatTheyShareBefore) {
  EXPECT_EQ(rounds_of(graph_of(
                "nodes:\n"
                "  a: {type: Constant}\n"
                "  b: {type: Clamp, each: {k: [1, 2]}, inputs: {in: a.out}, params: {high: '${k}'}}\n"
                "  sum: {type: Sum, inputs: {in: b.out}}\n"
                "  end: {type: Clamp, inputs: {in: sum.out}}\n")),
            "a | b[1]: b[1]; b[2]: b[2];\n");
}

TEST(GraphParts, AChainOfElementsIsOnePart) {
  const Graph g = graph_of(
      "nodes:\n"
      "  a: {type: Constant, each: {k: [1, 2]}, params: {value: '${k}'}}\n"
      "  b: {type: Clamp, each: {k: [1, 2]}, inputs: {in: 'a[${k}].out'}}\n"
      "  sum: {type: Sum, inputs: {in: [b.out, 'a[2].out']}}\n");
  EXPECT_EQ(rounds_of(g), "| b[1]: b[1]; b[2]: a[2] b[2];\n");
  EXPECT_EQ(rounds_of(g, {"a[1]"}), "| a[1]: a[1];\n");
}

TEST(GraphParts, AListBeginsANewRound) {
  EXPECT_EQ(rounds_of(graph_of(
                "nodes:\n"
                "  a: {type: Constant, each: {k: [1, 2]}, params: {value: '${k}'}}\n"
                "  sum: {type: Sum, inputs: {in: a.out}}\n"
                "  b: {type: Clamp, each: {k: [3, 4]}, inputs: {in: sum.out}, params: {high: '${k}'}}\n"
                "  all: {type: Sum, inputs: {in: b.out}}\n")),
            "| a[1]: a[1]; a[2]: a[2];\n"
            "sum | b[3]: b[3]; b[4]: b[4];\n");
  // Also if an element takes the list itself, and if only one does.
  EXPECT_EQ(rounds_of(graph_of("nodes:\n"
                               "  a: {type: Constant, each: {k: [1, 2]}, params: {value: '${k}'}}\n"
                               "  b: {type: Sum, each: {k: [3]}, inputs: {in: a.out}}\n")),
            "| a[1]: a[1]; a[2]: a[2];\n"
            "| b[3]: b[3];\n");
}

TEST(GraphParts, AnElementThatSeveralUseIsComputedOnce) {
  EXPECT_EQ(
      rounds_of(graph_of("nodes:\n"
                         "  a: {type: Constant, each: {k: [1, 2]}, params: {value: '${k}'}}\n"
                         "  b: {type: Clamp, each: {k: [1, 2], j: [5, 6]}, inputs: {in: 'a[${k}].out'},\n"
                         "      params: {high: '${j}'}}\n")),
      "| a[1]: a[1]; a[2]: a[2];\n"
      "| b[1,5]: b[1,5]; b[1,6]: b[1,6]; b[2,5]: b[2,5]; b[2,6]: b[2,6];\n");
}

TEST(GraphParts, NodesThatWriteFilesAreLeftToTheRun) {
  EXPECT_EQ(rounds_of(graph_of("nodes:\n"
                               "  a: {type: Constant, each: {k: [1, 2]}, params: {value: '${k}'}}\n"
                               "  file: {type: Write, each: {k: [1, 2]}, inputs: {in: 'a[${k}].out'},\n"
                               "         params: {path: '${k}.csv'}}\n")),
            "| a[1]: a[1]; a[2]: a[2];\n");
}

// After the targets of all rounds, no element is left, and no round computes an element of another one.
TEST(GraphParts, EveryElementIsComputedOnceAndInOrder) {
  std::string text = "nodes:\n  c0: {type: Constant}\n";
  std::uint64_t seed = 7;
  const auto random = [&](std::uint64_t n) {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (seed >> 33) % n;
  };
  for (int trial = 0; trial < 200; ++trial) {
    std::string nodes = text;
    std::vector<std::string> lists, singles = {"c0"};
    for (int i = 1; i < 9; ++i) {
      const std::string name = "n" + std::to_string(i);
      const auto kind = random(5);
      const std::string single = singles[random(singles.size())];
      const std::string list = lists.empty() ? single : lists[random(lists.size())];
      if (kind == 0 || lists.empty()) {
        nodes += "  " + name + ": {type: Clamp, each: {k: [1, 2, 3]}, inputs: {in: " + single + ".out}}\n";
        lists.push_back(name);
      } else if (kind == 1) {
        nodes += "  " + name + ": {type: Sum, inputs: {in: [" + list + ".out, " + single + ".out]}}\n";
        singles.push_back(name);
      } else if (kind == 2) {
        nodes +=
            "  " + name + ": {type: Clamp, each: {k: [1, 2, 3]}, inputs: {in: '" + list + "[${k}].out'}}\n";
        lists.push_back(name);
      } else if (kind == 3) {
        nodes += "  " + name + ": {type: Sum, each: {k: [1, 2, 3]}, inputs: {in: [" + list + ".out, '" +
                 lists[random(lists.size())] + "[2].out']}}\n";
        lists.push_back(name);
      } else {
        nodes += "  " + name + ": {type: Add, each: {k: [1, 2, 3]}, inputs: {a: '" + list +
                 "[${k}].out', b: '" + lists[random(lists.size())] + "[${k}].out'}}\n";
        lists.push_back(name);
      }
    }
    const Graph g = graph_of(nodes);
    std::vector<bool> done(g.nodes.size());  // computed in an earlier round, or by the job for what is shared
    for (const auto& round : graph_rounds(g, g.sinks())) {
      const auto compute = [&](const std::vector<std::string>& targets, std::vector<bool> known) {
        std::vector<int> fresh;
        std::vector<int> open = target_nodes(g, targets);
        while (!open.empty()) {
          const auto i = static_cast<std::size_t>(open.back());
          open.pop_back();
          if (known[i]) continue;
          known[i] = true;
          fresh.push_back(static_cast<int>(i));
          for (const auto& [port, wires] : g.nodes[i].inputs)
            for (const auto& w : wires) open.push_back(w.node);
        }
        return fresh;
      };
      for (const int i : compute(round.shared, done)) {
        EXPECT_EQ(g.nodes[static_cast<std::size_t>(i)].path.find('['), std::string::npos) << nodes;
        done[static_cast<std::size_t>(i)] = true;
      }
      std::vector<int> all;
      for (const auto& part : round.parts) {
        ASSERT_FALSE(part.targets.empty()) << nodes;
        const auto fresh = compute(part.targets, done);
        all.insert(all.end(), fresh.begin(), fresh.end());
      }
      std::sort(all.begin(), all.end());
      EXPECT_EQ(std::adjacent_find(all.begin(), all.end()), all.end()) << "two parts compute one node\n"
                                                                       << nodes;
      // Only targets are in the cache for others; but what is inside a part nobody else needs.
      for (const int i : all) done[static_cast<std::size_t>(i)] = true;
    }
    for (std::size_t i = 0; i < g.nodes.size(); ++i)
      EXPECT_TRUE(done[i] || g.nodes[i].path.find('[') == std::string::npos) << g.nodes[i].path << "\n"
                                                                             << nodes;
  }
}

}  // namespace
}  // namespace terrazzo

#include "runtime/report/graph_parts.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "runtime/run_result.h"

namespace terrazzo {
namespace {

// The element that a node belongs to: "field[wood]" for "field[wood]/source". "" if it is none.
std::string element_of(const std::string& path) {
  const auto end = path.rfind(']');
  return end == std::string::npos ? "" : path.substr(0, end + 1);
}

// Elements by number, and which of them are computed together.
class Elements {
 public:
  Elements(const Graph& graph, const std::vector<bool>& needed)
      : graph_(graph), of_node_(graph.nodes.size(), -1) {
    std::map<std::string, int> numbers;
    for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
      // Files belong into the output folder of the run, so nodes that write them are left to it.
      if (!needed[i] || graph.nodes[i].type->writes_files) continue;
      if (const std::string element = element_of(graph.nodes[i].path); !element.empty())
        of_node_[i] = numbers.try_emplace(element, static_cast<int>(numbers.size())).first->second;
    }
    together_.resize(numbers.size());
    std::iota(together_.begin(), together_.end(), 0);
    join_chains();
  }

  // The smallest number of the elements that are computed with this node; −1 if it is no element.
  int part_of(std::size_t node) { return of_node_[node] < 0 ? -1 : root(of_node_[node]); }

 private:
  int& next(int e) { return together_[e]; }
  int root(int e) {
    while (next(e) != e) e = next(e) = next(next(e));
    return e;
  }

  // An element is computed with the only one that uses it, unless that one takes a list of elements.
  void join_chains() {
    constexpr int kSeveral = -1;
    std::map<int, int> only_user;
    for (std::size_t i = 0; i < graph_.nodes.size(); ++i) {
      const int user = of_node_[i];
      if (user < 0) continue;
      for (const auto& [port, wires] : graph_.nodes[i].inputs) {
        std::set<int> sources;
        for (const auto& w : wires)
          if (const int s = of_node_[w.node]; s >= 0 && s != user) sources.insert(s);
        for (const int s : sources) {
          const auto [known, fresh] = only_user.try_emplace(s, user);
          if (known->second != user || sources.size() > 1) known->second = kSeveral;
        }
      }
    }
    for (const auto& [source, user] : only_user) {
      if (user == kSeveral) continue;
      const int a = root(source), b = root(user);
      next(std::max(a, b)) = std::min(a, b);
    }
  }

  const Graph& graph_;
  std::vector<int> of_node_;   // −1: no element
  std::vector<int> together_;  // a forest of elements
};

}  // namespace

std::vector<GraphRound> graph_rounds(const Graph& graph, const std::vector<int>& targets) {
  const std::size_t n = graph.nodes.size();
  const auto needed = needed_nodes(graph, targets);
  Elements elements(graph, needed);
  const auto each_source = [&](std::size_t i, auto&& use) {
    for (const auto& [port, wires] : graph.nodes[i].inputs)
      for (const auto& w : wires) use(static_cast<std::size_t>(w.node));
  };
  std::vector<std::size_t> round(n);
  std::vector<bool> used_inside(n), used_outside(n);
  for (std::size_t i = 0; i < n; ++i) {  // sources come before their consumers
    if (!needed[i]) continue;
    each_source(i, [&](std::size_t s) {
      const bool other = elements.part_of(s) >= 0 && elements.part_of(s) != elements.part_of(i);
      round[i] = std::max(round[i], round[s] + other);
    });
    each_source(i, [&](std::size_t s) {
      const bool inside = elements.part_of(s) == elements.part_of(i) && round[s] == round[i];
      (inside ? used_inside : used_outside)[s] = true;
    });
  }
  for (const int t : targets) used_outside[t] = true;
  std::vector<GraphRound> out;
  std::map<std::pair<std::size_t, int>, std::size_t> at;  // of a part in its round
  std::vector<std::set<std::size_t>> shared;              // by round
  for (std::size_t i = 0; i < n; ++i) {
    const int part = needed[i] ? elements.part_of(i) : -1;
    if (part < 0) continue;
    if (out.size() <= round[i]) {
      out.resize(round[i] + 1);
      shared.resize(round[i] + 1);
    }
    auto& parts = out[round[i]].parts;
    const auto [known, fresh] = at.try_emplace({round[i], part}, parts.size());
    if (fresh) parts.emplace_back();
    parts[known->second].name = element_of(graph.nodes[i].path);
    if (used_outside[i] || !used_inside[i]) parts[known->second].targets.push_back(graph.nodes[i].path);
    each_source(i, [&](std::size_t s) {
      if (elements.part_of(s) < 0) shared[round[i]].insert(s);
    });
  }
  for (std::size_t r = 0; r < out.size(); ++r)
    for (const auto s : shared[r]) out[r].shared.push_back(graph.nodes[s].path);
  std::erase_if(out, [](const GraphRound& r) { return r.parts.empty(); });
  return out;
}

}  // namespace terrazzo

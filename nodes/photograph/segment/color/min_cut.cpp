#include "nodes/photograph/segment/color/min_cut.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terrazzo::segment {
namespace {

struct Arc {
  std::int32_t to;
  std::int64_t left;  // capacity left; the reverse arc has the index with the last bit flipped
};

class Flow {
 public:
  explicit Flow(int nodes) : out_(nodes), level_(nodes), next_(nodes) {}

  void add(int a, int b, std::int64_t forth, std::int64_t back) {
    if (forth == 0 && back == 0) return;
    out_[a].push_back(arcs_.size());
    arcs_.push_back({b, forth});
    out_[b].push_back(arcs_.size());
    arcs_.push_back({a, back});
  }

  // Computes the maximum flow. Afterwards level ≥ 0 marks the source's side.
  void run(int source, int sink, const Work& work) {
    while (find_levels(source, sink)) {
      work.check();
      std::fill(next_.begin(), next_.end(), 0);
      while (push_path(source, sink)) {
      }
    }
  }
  bool from_source(int node) const { return level_[node] >= 0; }

 private:
  bool find_levels(int source, int sink) {
    std::fill(level_.begin(), level_.end(), -1);
    std::vector<int> queue{source};
    level_[source] = 0;
    for (std::size_t k = 0; k < queue.size(); ++k)
      for (const auto e : out_[queue[k]])
        if (arcs_[e].left > 0 && level_[arcs_[e].to] < 0) {
          level_[arcs_[e].to] = level_[queue[k]] + 1;
          queue.push_back(arcs_[e].to);
        }
    return level_[sink] >= 0;
  }

  // Pushes flow along one path of increasing levels. Depth-first search without recursion.
  bool push_path(int source, int sink) {
    std::vector<std::int32_t>& path = path_;
    path.clear();
    int at = source;
    while (at != sink) {
      bool forward = false;
      for (auto& k = next_[at]; k < out_[at].size(); ++k) {
        const auto e = out_[at][k];
        if (arcs_[e].left <= 0 || level_[arcs_[e].to] != level_[at] + 1) continue;
        path.push_back(e);
        at = arcs_[e].to;
        forward = true;
        break;
      }
      if (forward) continue;
      if (path.empty()) return false;
      at = arcs_[path.back() ^ 1].to;
      path.pop_back();
      ++next_[at];
    }
    std::int64_t amount = std::numeric_limits<std::int64_t>::max();
    for (const auto e : path) amount = std::min(amount, arcs_[e].left);
    for (const auto e : path) {
      arcs_[e].left -= amount;
      arcs_[e ^ 1].left += amount;
    }
    return true;
  }

  std::vector<std::vector<std::int32_t>> out_;
  std::vector<Arc> arcs_;
  std::vector<int> level_;
  std::vector<std::size_t> next_;
  std::vector<std::int32_t> path_;
};

std::int64_t units(double cost) { return std::llround(cost * 4096); }

}  // namespace

std::vector<bool> min_cut(const std::vector<double>& cost_false, const std::vector<double>& cost_true,
                          const std::vector<CutEdge>& edges, const Work& work) {
  const int n = cost_false.size(), source = n, sink = n + 1;
  Flow flow(n + 2);
  for (int k = 0; k < n; ++k) {
    // Only the difference matters. A node on the source's side is true: cutting it off from the source costs
    // cost_false.
    const std::int64_t d = units(cost_false[k]) - units(cost_true[k]);
    if (d > 0)
      flow.add(source, k, d, 0);
    else
      flow.add(k, sink, -d, 0);
  }
  for (const auto& e : edges) flow.add(e.a, e.b, units(e.weight), units(e.weight));
  flow.run(source, sink, work);
  std::vector<bool> label(n);
  for (int k = 0; k < n; ++k) label[k] = flow.from_source(k);
  return label;
}

}  // namespace terrazzo::segment

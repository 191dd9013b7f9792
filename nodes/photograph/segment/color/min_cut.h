// Minimum-cost binary labeling of a graph.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::segment {

struct CutEdge {
  std::int32_t a = 0, b = 0;
  double weight = 0;  // cost if a and b get different labels, ≥ 0
};

// The labeling (true or false per node) that minimizes the sum of cost_true[n] or cost_false[n] over the
// nodes plus the weights of the cut edges. Uses Dinic's maximum flow algorithm (1970) in integer units of
// 1/4096, so the result is exact. Ties become false.
std::vector<bool> min_cut(const std::vector<double>& cost_false, const std::vector<double>& cost_true,
                          const std::vector<CutEdge>& edges, const Work&);

}  // namespace terrazzo::segment

// Two labels on a graph at least cost.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo {

struct CutEdge {
  std::int32_t a = 0, b = 0;
  double weight = 0;  // cost where a and b get different labels, ≥ 0
};

// The labelling (true or false per node) with the least sum of cost_true[n] or cost_false[n] and of the edges
// cut: the minimum cut by Dinic's algorithm (1970), in whole units of 1/4096, so that it is exact. Ties go to
// false.
std::vector<bool> min_cut(const std::vector<double>& cost_false, const std::vector<double>& cost_true,
                          const std::vector<CutEdge>& edges, const Work&);

}  // namespace terrazzo

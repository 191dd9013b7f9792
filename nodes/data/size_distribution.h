// SizeDistribution: particles per volume by size class.
#pragma once

#include <vector>

#include "runtime/value.h"

namespace terrazzo {

struct SizeDistribution {
  struct Entry {
    int shape = 0;                  // index into Shapes, or −1: any, by the shapes' own probabilities
    int cls = 0;                    // colour or particle class
    std::vector<double> N_V;        // per mm³ and size class
    std::vector<double> low, high;  // 90 % interval of each; equal to N_V where nothing is known
  };
  std::vector<double> class_edges;  // n + 1 sizes, mm, rising; sizes are √(4·A_max/π)
  std::vector<Entry> shapes;
  double volume_fraction = 0;
  double d_max = 0;            // size of the largest particle, mm
  double goodness_of_fit = 0;  // χ² per degree of freedom of the refitted N_A; 0 where there was no fit

  std::size_t classes() const { return class_edges.empty() ? 0 : class_edges.size() - 1; }
};

template <>
const ValueType& value_type<SizeDistribution>();

}  // namespace terrazzo

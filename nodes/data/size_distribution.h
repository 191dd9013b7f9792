// SizeDistribution: number of particles per volume in each size class.
#pragma once

#include <vector>

#include "runtime/value.h"

namespace terrazzo {

struct SizeDistribution {
  struct Entry {
    int shape = 0;                  // index into Shapes; −1: any shape, by the probabilities of the shapes
    int cls = 0;                    // color or particle class
    std::vector<double> N_V;        // per mm³ and size class
    std::vector<double> low, high;  // 90 % interval of each; equal to N_V if unknown
  };
  std::vector<double> class_edges;  // n + 1 increasing sizes in mm; a size is √(4·A_max/π)
  std::vector<Entry> shapes;
  double volume_fraction = 0;
  double d_max = 0;            // size of the largest particle, mm
  double goodness_of_fit = 0;  // χ² per degree of freedom of the refitted N_A; 0 without a fit

  std::size_t classes() const { return class_edges.empty() ? 0 : class_edges.size() - 1; }
};

template <>
const ValueType& value_type<SizeDistribution>();

}  // namespace terrazzo

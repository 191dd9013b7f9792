// KMatrix: how often a particle of size class j shows a profile of class i (Jagnow et al. 2004, eq. 3, 5, 6).
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "runtime/value.h"

namespace terrazzo {

struct KMatrix {
  struct Entry {
    double probability = 1;       // of this shape, by number
    double mean_caliper = 0;      // mm, at scale 1
    double max_section_area = 0;  // mm², at scale 1
    double volume = 0;            // mm³, at scale 1
    double profiles_per_caliper =
        1;  // expected profiles of a random plane that meets the hull; 1 when convex
    // n × n, row: profile class, column: size class, in equal classes of √(A/A_max). Expected profiles per
    // unit of the largest particle's mean caliper: N_A = H̄_max · K · N_V. The last column of `upper_edge`
    // sums to profiles_per_caliper.
    Eigen::MatrixXd K;
    // The distribution behind K: at [b], the share of a shape's profiles with √(A/A_max) ≤ (b + 1) /
    // cdf.size().
    std::vector<double> cdf;
  };
  int classes = 0;
  std::string averaging;  // "uniform" or "upper_edge"
  double residual =
      0;  // largest change of a class's probability between half and all of the samples, relative
  std::vector<Entry> shapes;
};

template <>
const ValueType& value_type<KMatrix>();

}  // namespace terrazzo

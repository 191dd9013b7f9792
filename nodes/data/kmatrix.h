// KMatrix: frequency of profiles of size class i from particles of size class j (Jagnow et al. 2004, eq. 3,
// 5, 6).
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "nodes/data/size_trend.h"
#include "runtime/value.h"

namespace terrazzo {

struct KMatrix {
  struct Entry {
    double probability = 1;       // fraction of all particles, by number
    SizeTrend trend;              // of the probability
    int cls = -1;                 // color or particle class whose particles have this shape; −1: any
    double mean_caliper = 0;      // mm, at scale 1
    double max_section_area = 0;  // mm², at scale 1
    double volume = 0;            // mm³, at scale 1
    // Expected number of profiles in a random plane that intersects the hull; 1 if convex.
    double profiles_per_caliper = 1;
    // n × n; row: profile class, column: particle class, both in equal classes of √(A/A_max). Expected number
    // of profiles, relative to the mean caliper diameter of the largest particle: N_A = H̄_max · K · N_V.
    // With averaging `upper_edge`, the last column sums to profiles_per_caliper.
    Eigen::MatrixXd K;
    // The distribution behind K: element b is the share of a shape's profiles with √(A/A_max) ≤ (b + 1) /
    // cdf.size().
    std::vector<double> cdf;
  };
  int classes = 0;
  std::string averaging;  // "uniform" or "upper_edge"
  // Largest relative change of a class's probability between half of the samples and all.
  double residual = 0;
  std::vector<Entry> shapes;
};

template <>
const ValueType& value_type<KMatrix>();

}  // namespace terrazzo

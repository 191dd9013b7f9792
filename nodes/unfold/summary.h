// What other programs report of sizes: means and quantiles.
#pragma once

#include <vector>

#include "nodes/data/size_distribution.h"

namespace terrazzo {

struct SizeSummary {
  double N_V = 0;                      // per mm³, all classes
  double mean = 0, median = 0;         // by number, mm
  double geometric_mean = 0;           // by number, mm
  double geometric_sd = 0;             // the factor exp(σ of ln size): a lognormal's multiplicative one
  double d10 = 0, d50 = 0, d90 = 0;    // sizes below which 10, 50, 90 % of the volume lies, mm
  std::vector<double> volume_share;    // of each class, Σ = 1
  std::vector<double> volume_passing;  // at each class's upper edge: the sieve curve, to 1
};

// Shapes and colour classes together; sizes are uniform within their class, volumes as the cube of the size.
// All zeros where there are no particles.
SizeSummary summarise(const SizeDistribution&);

}  // namespace terrazzo

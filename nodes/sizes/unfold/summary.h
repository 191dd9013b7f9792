// Summary statistics of sizes that other programs report: means and quantiles; and of shapes.
#pragma once

#include <vector>

#include "nodes/data/kmatrix.h"
#include "nodes/data/size_distribution.h"

namespace terrazzo::unfold {

struct SizeSummary {
  double N_V = 0;                      // per mm³, all classes
  double mean = 0, median = 0;         // by number, mm
  double geometric_mean = 0;           // by number, mm
  double geometric_sd = 0;             // exp(σ of ln size): a lognormal's multiplicative standard deviation
  double d10 = 0, d50 = 0, d90 = 0;    // sizes below which 10, 50, 90 % of the volume lies, mm
  std::vector<double> volume_share;    // of each class, Σ = 1
  std::vector<double> volume_passing;  // cumulative share at each class's upper edge: the sieve curve
};

// Over all shapes and color classes. Sizes are uniform within their class; volume is proportional to size³.
// All zeros if there are no particles.
SizeSummary summarize(const SizeDistribution&);

// Of a particle of size 1, averaged over the shapes of a K matrix: diameter of the sphere of the mean volume;
// 1 for spheres.
double equivalent_diameter(const KMatrix&);

// Mean over the shapes of a K matrix of volume / volume of the sphere with the same mean caliper diameter: 1
// for spheres, less for all other convex bodies.
double sphericity(const KMatrix&);

}  // namespace terrazzo::unfold

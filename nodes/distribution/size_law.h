// Laws of particle size in closed form, and size distributions made from them.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"

namespace terrazzo {

// A law of size s, mm, by its mean and standard deviation (of s itself, before it is cut to [min, max]).
class SizeLaw {
 public:
  // kind: "lognormal", "normal", "rosin_rammler" (Weibull), "uniform" (over [min, max]; mean and sd do not
  // matter). max ≤ 0: where 0.1 % of the law is left above. Throws Error "bad-law" where mean, sd, min and
  // max admit no law.
  SizeLaw(const std::string& kind, double mean, double sd, double min, double max);
  double min() const { return min_; }
  double max() const { return max_; }
  // Share of the cut law in [lo, hi].
  double share(double lo, double hi) const;

 private:
  double cumulative(double s) const;  // of the uncut law
  double upper_size(double share) const;
  std::string kind_;
  double mean_, sd_, min_, max_;
  double a_ = 0, b_ = 0;  // μ, σ of ln s; mean, sd; scale, exponent
};

struct DistributionOptions {
  std::string kind = "lognormal";   // or "classes", "normal", "uniform", "rosin_rammler"
  double mean = 1, sd = 0.3;        // mm
  double min = 0, max = 0;          // mm; max 0: see SizeLaw
  int classes = 10;                 // equal ones of [min, max], where class_edges is empty
  std::vector<double> class_edges;  // mm, rising
  std::vector<double> N_V;          // of kind "classes": per class, per mm³ or relative
  double volume_fraction = 0;       // 0: not given
  double number_density = 0;        // per mm³; 0: not given
  bool by_volume = false;           // the law is of the share of volume, not of number, by size
};

// One entry that leaves the shape to the shapes' own probabilities. Volumes are those of `shapes` (null:
// spheres of the same size), sizes being uniform within a class. Throws Error "bad-law", "bad-classes",
// "no-amount", "two-amounts".
SizeDistribution make_distribution(const DistributionOptions&, const Shapes* shapes);

}  // namespace terrazzo

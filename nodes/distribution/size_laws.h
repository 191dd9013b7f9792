// Size distributions written down: laws of the particles' sizes, cut into classes.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"

namespace terrazzo {

struct SizeLaw {
  std::string kind = "lognormal";  // classes, lognormal, normal, uniform, rosin_rammler
  double mean = 5;                 // mm; of rosin_rammler the size that 63.2 % are below
  double sd = 1.5;                 // mm
  double exponent = 3;             // of rosin_rammler
  double min = 0, max = 0;         // mm, where the law is cut off; max 0: where 0.1 % are left
  bool of_volume = false;          // the law tells volume by size, not number
  int classes = 10;
  std::vector<double> class_edges;  // of `classes`: n + 1 sizes, mm, rising
  std::vector<double> N_V;          // of `classes`: n densities, per mm³
  double volume_fraction = -1;      // < 0: not given
  double number_density = -1;       // per mm³; < 0: not given
  bool by_class = false;            // each shape is a class of its own, with its probability's share
};

// Share of the law below a size: closed forms.
double law_cdf(const SizeLaw&, double size);

// Classes of equal width between min and max, each with the law's share; `shapes` (may be null: spheres) tell
// what volume a size has. Where neither fraction nor density is given a law fills 0.3, and classes stay as
// they are. Throws Error "bad-classes", "bad-range", "both-given", "too-full".
SizeDistribution make_distribution(const SizeLaw&, const Shapes* shapes);

}  // namespace terrazzo

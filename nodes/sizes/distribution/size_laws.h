// Size distributions defined by hand: laws of particle size, divided into classes.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"

namespace terrazzo::distribution {

enum class LawKind { Classes, Lognormal, Normal, Uniform, RosinRammler, EqualVolume };
enum class DensityBy { Number, Volume };  // what the law distributes
enum class Types {
  Mixed,   // particles of any shape
  ByClass  // each shape is a separate class with the share of its probability
};

struct SizeLaw {
  LawKind kind = LawKind::Lognormal;
  double mean = 5;          // mm; for rosin_rammler, 63.2 % of the sizes are smaller
  double sd = 1.5;          // mm
  double exponent = 3;      // of rosin_rammler
  double min = 0, max = 0;  // mm, where the law is cut off; max 0: the size that 0.1 % exceed
  DensityBy density_by = DensityBy::Number;
  int classes = 10;                 // number of equal classes of a law
  std::vector<double> class_edges;  // for `classes`: n + 1 increasing sizes, mm
  std::vector<double> N_V;          // for `classes`: n densities, per mm³
  std::vector<double> low, high;    // for `classes`: ends of the 90 % intervals of N_V; empty: unknown
  double volume = 1;                // for `equal_volume`: of each particle, mm³
  double volume_fraction = -1;      // < 0: not set
  double number_density = -1;       // per mm³; < 0: not set
  Types types = Types::Mixed;
};

// Share of the law below a size, in closed form. Not for `classes` and `equal_volume`.
double law_cdf(const SizeLaw&, double size);

// Throws Error "bad-classes", "bad-range", "both-given", "too-full" for a law that no shapes can satisfy.
void check_law(const SizeLaw&);

// Half the width of a class of `equal_volume`, relative to its size: the widths of classes must be positive.
inline constexpr double kEqualVolumeWidth = 1e-6;

// Divides the law into classes of equal width between min and max; `equal_volume` gives every shape the one
// size at which it has the volume, and a narrow class around it. `shapes` determine the volume of a particle
// of a given size (null: spheres). If neither volume_fraction nor number_density is set, a law has volume
// fraction 0.3, and kind "classes" keeps its N_V. Throws Error "bad-classes", "bad-range", "both-given",
// "too-full", "no-shapes", "unmeasured-shape".
SizeDistribution make_distribution(const SizeLaw&, const Shapes* shapes);

}  // namespace terrazzo::distribution

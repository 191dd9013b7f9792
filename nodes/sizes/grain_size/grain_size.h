// Statistics of the sizes that profiles show, as sedimentologists and metallographers report them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/stereology/profile_columns.h"
#include "nodes/data/profiles.h"
#include "nodes/data/size_distribution.h"
#include "runtime/work.h"

namespace terrazzo::grain_size {

enum class Diameter { Equivalent, MajorAxis, MinorAxis, FeretMax, FeretMin };

// What each profile counts.
enum class Weighting {
  Number,  // its weight
  Area,    // its weight × area: what grid points hit
  Weight   // its weight × diameter³: what sieves weigh, if all have one shape and density
};
inline constexpr std::array<Weighting, 3> kWeightings = {Weighting::Number, Weighting::Area,
                                                         Weighting::Weight};
const char* name_of(Weighting);  // "by number"
inline constexpr std::array<int, 5> kPercents = {10, 16, 50, 84, 90};

// The profiles that count, by increasing diameter.
struct Sizes {
  std::vector<double> diameter, area, weight;  // mm, mm², number
  std::vector<int> section;
  std::array<std::vector<double>, 3> amounts;  // what they count in each weighting
  // 0 if an outline is unknown: its area, and the lengths of its shadows on the x and y axis, there and back.
  std::vector<double> enclosed, width, height;  // mm², mm
  int sections = 1;
  bool outlined = false;  // all of them
};

// `columns`: profile_columns of the profiles. Profiles of weight 0, which touch the border, do not count.
// Throws Error "no-profiles", "no-outlines", "bad-profile" for one without area.
Sizes sizes_of(const Profiles&, const std::vector<ProfileColumn>& columns, Diameter);

// The share that smaller profiles and half of each make up.
struct Curve {
  std::vector<double> diameter, share;
};
Curve curve_of(const Sizes&, Weighting);

struct Measure {
  std::string name, unit;
  double value = 0, low = 0, high = 0;  // 5 % and 95 % quantiles of the bootstrap
};

// D10 to D90, by linear interpolation of the curve (Hazen 1914), and the mean and the geometric mean by each
// weighting, in mm. With outlines also the mean intercepts of infinitely many lines along x, along y, and
// along both, which steps of pixels do not shorten, and the grain size numbers of ASTM E112 by area and by
// intercepts. Repetition r of the bootstrap draws from Random(seed, 1, r).
std::vector<Measure> measures_of(const Sizes&, int repetitions, std::uint64_t seed, const Work& = {});

// ln(N_V / width of the class) against size (Marsh 1988), and the line through it by least squares.
struct CrystalSizes {
  std::vector<double> size, density;  // mm, ln of 1/mm⁴
  double slope = 0, intercept = 0;    // 1/mm, ln of 1/mm⁴
  bool relative = false;              // N_V is not per mm³, so that only the slope counts
};
// Throws Error "too-few-profiles" if fewer than two size classes have particles.
CrystalSizes crystal_sizes(const SizeDistribution&);

}  // namespace terrazzo::grain_size

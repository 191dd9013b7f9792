// The input of unfolding: profile sizes and weights per color class.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/profiles.h"

namespace terrazzo::unfolding {

// Volume fraction of loose stones, and its relative error. Balls fill 0.60 to 0.64 (Scott and Kilgour 1969),
// stones that were only dropped 0.55; smaller ones between large ones add some.
inline constexpr double kLooseFraction = 0.58, kLooseError = 0.07;

enum class Border {
  Weights,  // each profile has Profile::weight: zero for those cut by the border, more for larger ones
  Inside,   // profiles that the border does not cut have weight 1, the others 0
  All       // every profile has weight 1, cut ones with their visible area
};

struct Observation {           // one color class
  std::vector<double> size;    // √(4·A/π), mm, of each profile used; of a surface, of its silhouette
  std::vector<double> weight;  // number of profiles that it represents, > 0
  std::vector<int> section;    // index of its section
  std::vector<std::size_t> profile;  // its index in Profiles
  double area_fraction = 0;          // share of the section's area, cut profiles included; 0: unknown, as of
  // a surface
};

struct Observations {
  double area = 0;        // mm² observed
  bool relative = false;  // the area is unknown and set arbitrarily: only ratios of densities are meaningful
  int sections = 1;
  std::vector<Observation> classes;
  // Number of profiles used, left out at the border, and below the smallest visible size.
  std::size_t used = 0, cut = 0, hidden = 0;
  double largest = 0;  // size of the largest profile used, mm
};

// `area_fraction` (0: unknown) overrides that of the profiles. If observed_area is
// unknown, the area is Σ areas / area_fraction; if neither is known, densities are
// relative. Throws Error "no-profiles", "bad-profiles".
Observations observe(const Profiles&, Border, double smallest_visible, double area_fraction);

}  // namespace terrazzo::unfolding

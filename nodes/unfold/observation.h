// What unfolding takes from profiles: sizes and weights per colour class.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/profiles.h"

namespace terrazzo {

enum class Border {
  Weights,  // each profile counts as Profile::weight: those cut by the border not, larger ones more
  All,      // every profile counts once, cut ones with what is left of them
  Inside    // those that the border does not cut count once
};

struct Observation {           // one colour class
  std::vector<double> size;    // √(4·A/π), mm, of each profile that counts
  std::vector<double> weight;  // profiles that it stands for, > 0
  std::vector<int> section;    // it lies in
  double area_fraction = 0;    // of the section's area, cut profiles included
};

struct Observations {
  double area = 0;        // mm² observed
  bool relative = false;  // the area is unknown and made up: densities tell ratios only
  int sections = 1;
  std::vector<Observation> classes;
  std::size_t used = 0, cut = 0,
              hidden = 0;  // profiles: taken, left out at the border, below the smallest visible
  double largest = 0;      // size, mm
};

// `area_fraction` (0: unknown) stands in where observed_area is unknown: observed = Σ areas / area_fraction.
// Where neither is known densities are relative. Throws Error "no-profiles", "bad-profiles".
Observations observe(const Profiles&, Border, double smallest_visible, double area_fraction);

}  // namespace terrazzo

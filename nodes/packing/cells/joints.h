// The binder between neighbors in a section.
#pragma once

#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo::tessellation {

struct Joints {
  double thickness = 0;  // mm, between the surfaces of neighboring particles: median
  double variation = 0;  // half the range between the quartiles, relative to the median; at most 1
};

// Measures the distance from points of each outline to the nearest outline of another profile. Points farther
// from all than half a mean diameter are left out. A section cuts a film obliquely, so the median distance is
// divided by 1.09, the median of 1/sin over the angles at which random planes meet a plane. All zero without
// two outlines.
Joints measure_joints(const Profiles& profiles, const Work& work = {});

}  // namespace terrazzo::tessellation

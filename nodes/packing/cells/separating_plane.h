// Planes between two bodies.
#pragma once

#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::tessellation {

// A direction and the distance of the two bodies along it; negative if they overlap along it.
struct Separation {
  Vec3 normal;  // unit vector from the first body to the second
  double gap = 0;
  double end = 0;    // the first body ends at normal·x = end, in its own coordinates
  double start = 0;  // the second body begins at normal·x = start, in the coordinates of the first
};

// A direction along which the two sets of points are as far apart as an ascent finds: the largest `gap` of 40
// steps, starting from the direction between the origins. `apart` (not zero) is the second body's origin in
// the coordinates of the first.
Separation widest_separation(const std::vector<Vec3>& first, const std::vector<Vec3>& second,
                             const Vec3& apart);

}  // namespace terrazzo::tessellation

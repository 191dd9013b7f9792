// A made-up scan of a limb: skin, fat, muscles in their sheaths, bones with marrow; so that pictures of scans
// need nobody's body.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/work.h"

namespace terrazzo::phantom {

struct LimbChoice {
  Vec3i resolution = Vec3i(80, 80, 120);
  double length = 240;  // mm, along z; it is two thirds as wide and as deep
  double noise = 8;     // standard deviation of each voxel, Hounsfield units
  std::uint64_t seed = 1;

  Vec3 box() const { return Vec3(2 * length / 3, 2 * length / 3, length); }        // mm
  Vec3 spacing() const { return box().cwiseQuotient(resolution.cast<double>()); }  // mm
};

// Voxels of the scan in Hounsfield units, x fastest. The limb is cut through at z = 0, where it is thick, and
// ends in the air at the other end. Surfaces are antialiased: a voxel that tissues share has their mean. What
// is whole (air, the length of a shaft) is −1000, fat near −100, muscle near 55, marrow near −60, compact
// bone near 1200. Skin, a layer of 2 mm, has −250: scanned voxels hold it and air alike.
std::vector<float> limb(const LimbChoice&, const Work& = {});

}  // namespace terrazzo::phantom

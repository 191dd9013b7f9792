// A synthetic scan of a limb: skin, fat, muscles in their sheaths, bones with marrow. It makes pictures of
// scans possible without patient data.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::phantom {

struct LimbOptions {
  Vec3i resolution = Vec3i(80, 80, 120);
  double length = 240;  // mm, along z; width and depth are two thirds of it
  double noise = 8;     // standard deviation of each voxel, Hounsfield units
  std::uint64_t seed = 1;

  Vec3 box() const { return Vec3(2 * length / 3, 2 * length / 3, length); }        // mm
  Vec3 spacing() const { return box().cwiseQuotient(resolution.cast<double>()); }  // mm
};

// Voxels of the scan in Hounsfield units, x fastest. The limb is cut at z = 0, where it is thick, and ends in
// air at the other end. Surfaces are antialiased: a voxel shared by several tissues has their mean. Pure
// values are −1000 for air, near −100 for fat, 55 for muscle, −60 for marrow, and 1200 for compact bone.
// Skin, a layer of 2 mm, has −250, because scanned voxels contain both skin and air.
std::vector<float> limb(const LimbOptions&, const Work& = {});

}  // namespace terrazzo::phantom

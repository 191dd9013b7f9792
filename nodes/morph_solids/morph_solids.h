// Solids between two solids.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/morph_solids/torus.h"
#include "runtime/work.h"

namespace terrazzo::morph_solids {

struct MorphSettings {
  std::vector<int> iterations = {30, 8};  // per level, coarsest first; the last one repeats
  double exponent = 0.8;                  // r of ‖·‖^r
  double window = 0.02;  // of the mean shift at the end of each level; it starts ten times as wide
  double overuse = 1;    // penalty on patches used more often than average
  std::uint64_t seed = 1;
};

struct MorphResult {
  Torus<Vec3f> color;  // scene-linear
  int levels = 1;
  std::size_t synthesized = 0;  // voxels; the others are those of a or b
};

// `a` and `b` are scene-linear colors of one size, at least 16 voxels along each axis, and tile. `weight` is
// the share of `b` at each voxel, 0 to 1. Voxels of weight 0 and 1 are those of a and b, bit for bit. Throws
// Error "one-color".
MorphResult morph(const Torus<Vec3f>& a, const Torus<Vec3f>& b, const Torus<float>& weight,
                  const MorphSettings&, const Work&);

// Peak memory in bytes.
double morph_memory(const Vec3i& size);

}  // namespace terrazzo::morph_solids

// Synthesizes from noise a solid whose slices have the co-occurrence matrices of pictures: the
// three-dimensional form of Malzbender and Spach 1993, section 3.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/texture/coarse_descent.h"
#include "nodes/common/texture/color_levels.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::cooccurrence_solid {

struct SolidFieldOptions {
  int levels = 8, extent = 2, scales = 1, sweeps = 10;
  Vec3i size = Vec3i::Constant(64);  // voxels
  ColorSpace space = ColorSpace::Oklab;
  Start start = Start::Coarse;
  std::uint64_t seed = 1;
};

struct SolidFieldResult {
  ColorLevels levels;
  LevelField field;                  // periodic; z upwards
  double noise_error = 0;            // E of the noise, over the three axes
  std::vector<DescentSweep> sweeps;  // from coarse to fine
  std::array<double, 3> axis_error;  // of the slices across each axis against its picture, at the end
};

// `pictures` are those for slices across x, y and z. On x and y a picture's columns run along y and x and its
// rows upwards along z; on z they run along x and y. Throws Error "too-small", "no-pixels", "one-color",
// "bad-pixels".
SolidFieldResult synthesize_solid(const std::array<const Image*, 3>& pictures, const SolidFieldOptions&,
                                  const Work& = {});

}  // namespace terrazzo::cooccurrence_solid

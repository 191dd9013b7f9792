// Fills a hole in a picture with pixels of a region, from coarse to fine, so that every patch looks like one
// of the region (Wexler, Shechtman, Irani 2007; Barnes et al. 2009). The hole is also matched to the region's
// color distribution. Without that, patches agree on smooth areas, and veins and joints disappear.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::texture_nib {

// One level of a pyramid (full size, half, quarter, …) of a picture's colors, in the space used for
// comparison, and of the mask of the region.
struct SourceLevel {
  int width = 0, height = 0;
  std::vector<Vec3f> color;
  std::vector<std::uint8_t> inside;
  std::vector<float> values[3];        // of each channel in the region, rising
  std::vector<std::uint32_t> centers;  // of the patches that are entirely inside
  std::vector<std::uint8_t> usable;    // 1 at these centers
};
using SourcePyramid = std::vector<SourceLevel>;
// Adds levels as long as they hold at least 200 patches. Has at least one level, which may have no centers.
SourcePyramid source_pyramid(int width, int height, const std::vector<Vec3f>& color,
                             const std::vector<std::uint8_t>& inside);

enum class HoleState : std::uint8_t { Unknown, Known, Hole };

// The part of a picture around the hole.
struct HolePicture {
  int width = 0, height = 0;
  std::vector<Vec3f> color;
  std::vector<HoleState> state;
};

// Returns the source pixel for each pixel of the hole; −1 elsewhere, and everywhere if the pyramid has no
// centers. Depends only on these arguments.
std::vector<std::int32_t> complete(const SourcePyramid&, HolePicture, std::uint64_t seed, std::uint64_t item,
                                   const Work& = {});

}  // namespace terrazzo::texture_nib

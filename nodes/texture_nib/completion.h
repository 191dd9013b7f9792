// Fills a hole of a picture with pixels of a region so that every patch looks like one of the region
// (Wexler, Shechtman, Irani 2007; Barnes et al. 2009), from coarse to fine, and the hole has the region's
// distribution of colours: without that the patches agree on what is smooth, and veins and joints go.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/work.h"

namespace terrazzo::texture_nib {

// A picture's colours in the space they are compared in, and its halves, quarters, …; which pixels are of the
// region.
struct SourceLevel {
  int width = 0, height = 0;
  std::vector<Vec3f> color;
  std::vector<std::uint8_t> inside;
  std::vector<float> values[3];        // of each channel in the region, rising
  std::vector<std::uint32_t> centers;  // of the patches that lie whole inside
  std::vector<std::uint8_t> usable;    // 1 at these
};
using SourcePyramid = std::vector<SourceLevel>;
// As many levels as still hold some hundred patches; one at least, which may have no centres.
SourcePyramid source_pyramid(int width, int height, const std::vector<Vec3f>& color,
                             const std::vector<std::uint8_t>& inside);

enum class HoleState : std::uint8_t { Unknown, Known, Hole };

// A part of a picture around the hole.
struct HolePicture {
  int width = 0, height = 0;
  std::vector<Vec3f> color;
  std::vector<HoleState> state;
};

// The source pixel for each pixel of the hole, −1 elsewhere and where the pyramid has no centres. A function
// of these alone.
std::vector<std::int32_t> complete(const SourcePyramid&, HolePicture, std::uint64_t seed, std::uint64_t item,
                                   const Work& = {});

}  // namespace terrazzo::texture_nib

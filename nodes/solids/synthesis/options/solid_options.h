// Settings of solid texture synthesis.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::solids {

constexpr const char* kAxes[3] = {"x", "y", "z"};  // as parameters and tables name them

// Sizes that decide how a blockwise solid is made, and so its result. Tests make them small.
struct BlockwiseLimits {
  double whole = 128.0 * 128 * 128;  // most voxels of the finest level that is made whole; the coarsest
                                     // always is. It takes as long as a block, since each run makes it again
  int probe = 80;    // edge in voxels of the cube where a level's statistics are measured; with 48, patch
                     // distances were a third larger
  int closed = 128;  // axes of at most so many voxels are measured and made in full, since a part would need
                     // as much around it
};

enum class SolidMethod {
  Coherence,  // tries neighbors' matches, similar patches and random ones
  Blockwise,  // makes the finer levels with passes that see only a bounded neighborhood
  Reference,  // Laursen, Ersbøll and Bærentzen 2011
};

// Color space of distances and means: Oklab, scene-linear Rec. 709, or display-encoded RGB (sRGB).
enum class SolidColor { Lab, Linear, Rgb };

struct SolidOptions {
  SolidMethod method = SolidMethod::Coherence;
  Vec3i size = Vec3i::Constant(64);
  std::array<int, 3> plane = {0, 0, 0};       // exemplar index for slices across x, y, z; −1: none
  std::vector<int> iterations = {20, 10, 5};  // per level, coarsest first; the last one repeats
  int levels = 0;                             // 0: until the smallest exemplar has 24 to 47 pixels per side
  SolidColor color = SolidColor::Lab;
  double exponent = 0.8;  // r of ‖·‖^r
  double overuse = 1;
  double copying = 1;            // penalty on copying the neighbors' exemplar layout (search.h)
  double guide = 1;              // weight of the guidance channel (guide.h), on levels that are made whole
  double window = 0.05;          // of the mean shift at the end of each level; it starts ten times as wide
  int finish = 2;                // rounds of matching the finest bands
  bool sources = false;          // record where each voxel comes from
  bool measured = true;          // compare planes of the solid with those of the exemplars
  int blockwise_iterations = 2;  // per blockwise level; 0: as in `iterations`
  Vec3i blocks = Vec3i::Ones();  // number of blocks of a blockwise solid along each axis
  BlockwiseLimits blockwise_limits;
  int block = 0;  // block to make: (z·blocks.y + y)·blocks.x + x
  std::uint64_t seed = 1;
};

}  // namespace terrazzo::solids

// Completes a picture that is known only in places.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

struct PartialPicture {
  int width = 0, height = 0;
  std::vector<Vec3f> value;         // row by row
  std::vector<std::uint8_t> known;  // 1 where `value` counts
};

// Fills unknown pixels with texture from the known ones: coarse to fine, every 7 × 7 patch that contains
// unknown pixels takes on the nearest patch of those known best (Wexler, Shechtman, Irani 2007; search after
// Barnes et al. 2009). Patches compare where the source is known, so that pieces narrower than a patch serve
// too. At the finest level, pixels are copied, which keeps their grain. At least one pixel must be known.
void fill_picture(PartialPicture&, std::uint64_t seed, const Work& = {});

}  // namespace terrazzo::detail_solid

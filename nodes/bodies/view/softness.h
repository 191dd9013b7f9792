// How soft a camera shows the outlines of stones.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::view {

// Blurs a picture, row by row, near its outlines, where `stone` changes from one pixel to the next, by a
// Gaussian of the deviation `pixels`; within stones, their skins are as soft as the photograph already. Less
// than 0.3 pixels change nothing.
void soften_outlines(Vec3f* picture, const std::vector<std::int32_t>& stone, int width, int height,
                     double pixels);

}  // namespace terrazzo::view

// Orientation of volume slices as images.
#pragma once

#include <array>

namespace terrazzo {

// Axes of the columns and rows of slices perpendicular to x, y and z. z points up wherever it is visible, so
// that an image of upright grain is oriented alike on x and on y.
constexpr std::array<int, 3> kSliceColumns = {1, 0, 0}, kSliceRows = {2, 2, 1};

}  // namespace terrazzo

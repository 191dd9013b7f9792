// How the slices of a volume are seen as pictures.
#pragma once

#include <array>

namespace terrazzo {

// Columns and rows of the pictures seen across x, y and z: z is up wherever it is seen, so that a picture of
// upright grain means the same on x and on y.
constexpr std::array<int, 3> kSliceColumns = {1, 0, 0}, kSliceRows = {2, 2, 1};

}  // namespace terrazzo

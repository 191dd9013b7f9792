// Binder pixels that are particles missed by the labels.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::residual {

// Indices of the pixels, among those marked in `binder`, that are farther than `limit` robust standard
// deviations (1.4826 · median absolute deviation, at least half a step of 8 bits) from their median in any
// channel. `encoded`: sRGB-encoded colors.
std::vector<std::size_t> find_specks(const Vec3f* encoded, const std::vector<std::uint8_t>& binder,
                                     double limit);

}  // namespace terrazzo::residual

// Distances to the outlines of labels.
#pragma once

#include <cstdint>
#include <vector>

namespace terrazzo::residual {

// For every pixel the distance in pixels from its center to the nearest outline between different ids, within
// the same picture; at least 0.5. `wrap`: opposite edges of the picture join. Pictures without outlines have
// distances of at least their diagonal.
std::vector<float> outline_depth(const std::int32_t* ids, int width, int height, bool wrap);

}  // namespace terrazzo::residual

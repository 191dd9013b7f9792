// Divides pixels without a particle among the particles, for materials without a binder.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"

namespace terrazzo::segment {

// `labels`: of one section of the image, 0 where no particle was found, else 1 to n. Places farther from all
// particles than 0.35 of their mean diameter become particles of their own, because something large was
// missed there. All others grow until they meet at edges of color (Meyer's flooding in OpenCV). Afterwards no
// pixel is 0, and the function returns the number of particles. Without any particle, the picture becomes
// one.
std::int32_t fill_gaps(std::vector<std::int32_t>& labels, const Image& image, int section);

}  // namespace terrazzo::segment

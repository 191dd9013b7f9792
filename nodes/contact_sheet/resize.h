// One section of a picture at another size.
#pragma once

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

// Smaller: Lanczos of three lobes in linear light, so that brightness stays. Larger: Catmull–Rom as displayed
// (in sRGB), so that edges between dark and light do not ring.
Image resized(const Image&, int section, int width, int height, const Work& = {});

}  // namespace terrazzo

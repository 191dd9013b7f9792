// Resizes one section of an image.
#pragma once

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::contact_sheet {

// Reduces with a three-lobed Lanczos filter in linear light, which preserves brightness. Enlarges with
// Catmull–Rom in sRGB, so that edges between dark and light do not ring.
Image resized(const Image&, int section, int width, int height, const Work& = {});

}  // namespace terrazzo::contact_sheet

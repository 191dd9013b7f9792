// The blur of outlines in a photograph.
#pragma once

#include "nodes/bodies/cutting/raster.h"
#include "nodes/data/linear.h"

namespace terrazzo::section {

// Blurs the flat colors of a picture and how much of each pixel particles cover, as the photograph blurs
// outlines. `sigma`: standard deviation, pixels; nothing happens below 0.2.
void soften(Vec3f* pixels, float* cover, const PixelGrid&, double sigma);

}  // namespace terrazzo::section

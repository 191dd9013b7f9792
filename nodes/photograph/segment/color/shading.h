// Uneven light across an image.
#pragma once

#include "nodes/photograph/segment/color/clustering.h"
#include "nodes/photograph/segment/color/mosaic.h"

namespace terrazzo::segment {

// Deviation of the local colors from the cluster centers, averaged over about an eighth of the image: slow
// changes of light, and stains (as in adaptive clustering; Pappas 1992). Patch colors, per pixel.
LabImage shading_of(const Mosaic&, const Clusters&, const Work&);

// Root mean square of a field.
float strength_of(const LabImage&);

// Subtracts the shading and computes the patches again.
void take_shading_away(Mosaic&, const LabImage& shading, const Work&);

}  // namespace terrazzo::segment

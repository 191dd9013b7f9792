// Uneven light across a picture.
#pragma once

#include "nodes/segment/clustering.h"
#include "nodes/segment/regions.h"

namespace terrazzo {

// How far the colours of a place lie from the clusters' centres, averaged over an eighth of the picture: slow
// changes of light and staining (as in adaptive clustering; Pappas 1992). Per pixel, patch colours.
LabImage shading_of(const Mosaic&, const Clusters&, const Work&);

// Root mean square of a field.
float strength_of(const LabImage&);

// Takes a shading away and makes the patches again.
void take_shading_away(Mosaic&, const LabImage& shading, const Work&);

}  // namespace terrazzo

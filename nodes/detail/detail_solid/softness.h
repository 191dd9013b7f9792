// How soft outlines are.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/labels.h"

namespace terrazzo::detail_solid {

// Standard deviation in pixels of the blur of outlines between particles and binder, at most 3: from the
// distance over which the mean step from one flat color to the other rises from 1/4 to 3/4, less the width of
// a pixel.
double outline_softness(const Image&, const Labels&);

}  // namespace terrazzo::detail_solid

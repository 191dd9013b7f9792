// Grains that grew together, such as the γ′ phase of a superalloy.
#pragma once

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "runtime/random.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

// Sets `id` and `particles` of an empty canvas: rounded cells in channels of even width. Some neighbors grew
// together and make one lobed grain; channels end within it as notches. What is connected is one particle.
// `fill`: area fraction, 0 to 1. Returns the width of a cell in canvas pixels.
double grow_together(Canvas&, double fill, Random&, const Work&);

// Soft pale or dark spots on grains and binder alike: what lies below the plane or on it.
void add_ghosts(Canvas&, double cell, Random&);

}  // namespace terrazzo::synthetic_photo

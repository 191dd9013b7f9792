// Pictures of solids, for browsers that cannot draw them.
#pragma once

#include "nodes/data/image.h"
#include "runtime/value.h"

namespace terrazzo::studio {

// Renders Particles with their shapes, Shapes side by side in the order of their set, or the block of a
// Volume with the grid Cd and a corner cut out: 640 × 480 pixels, as RenderSolid shows them, without fine
// detail. `shapes` may be empty except for Particles. `azimuth`: of the camera, degrees from +x towards +y.
// Throws Error "bad-request" for other types and for Particles without Shapes, and what particle_solid() and
// ColorField::of() throw.
Image solid_picture(const Value& solid, const Value& shapes, double azimuth);

}  // namespace terrazzo::studio

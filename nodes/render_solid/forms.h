// Bodies to carve: closed meshes, z up, the longest edge of the bounding box 1, standing on z = 0.
#pragma once

#include "nodes/data/shapes.h"

namespace terrazzo {

// A vase with a wall and a hollow, turned about z.
Shape vase_form();
// A trefoil knot of a round rope, as the torus knot that winds thrice around.
Shape knot_form();

}  // namespace terrazzo

// Bodies to carve: closed meshes, z up, standing on z = 0, with 1 as the longest edge of the bounding box.
#pragma once

#include "nodes/data/shapes.h"

namespace terrazzo::carving {

// A vase with a wall and a cavity, rotationally symmetric around z.
Shape vase_form();
// A trefoil knot of a round rope: the torus knot that winds three times around.
Shape knot_form();

}  // namespace terrazzo::carving

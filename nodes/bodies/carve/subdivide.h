// Splits triangles until none has an edge longer than a limit.
#pragma once

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::carve {

// Splits long edges in the middle, in both triangles that share them, so that a closed mesh stays closed. The
// surface stays the same. `longest` > 0, in the mesh's unit.
void subdivide(Mesh&, double longest, const Work& = {});

}  // namespace terrazzo::carve

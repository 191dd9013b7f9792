// Things in a photograph that are not material: rulers, tapes, scale cards, coins, pens, frames, color
// charts, captions with scale bars.
#pragma once

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "runtime/random.h"

namespace terrazzo::synthetic_photo {

// Covers parts of the canvas with none to a few objects. `micrograph`: captions and scale bars only.
void add_objects(Canvas&, bool micrograph, Random&);

}  // namespace terrazzo::synthetic_photo

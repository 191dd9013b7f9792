// Things with a scale: rulers, folding rulers, measuring tapes, scale cards.
#pragma once

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "runtime/random.h"

namespace terrazzo::synthetic_photo {

void add_ruler(Canvas&, Random&);
void add_folding_ruler(Canvas&, Random&);  // limbs at angles, with hinges
void add_tape(Canvas&, Random&);           // slightly bent
void add_scale_card(Canvas&, Random&);     // blocks of cm and inches, a checkerboard, grays, lines of text

}  // namespace terrazzo::synthetic_photo

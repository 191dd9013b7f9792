// Plane sections: profiles in a binder, as a saw, a polished face or a microscope shows them.
#pragma once

#include "nodes/synthetic_photo/canvas.h"
#include "nodes/synthetic_photo/palette.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

// `fill`: area fraction aimed at, 0 to 1. Cells of a power diagram above about 0.6, otherwise shapes dropped
// one after the other where there is room, so that neighbors may touch.
void make_plane_section(Canvas&, double fill, const PhotoPalette&, Random&, const Work&);

}  // namespace terrazzo::synthetic_photo

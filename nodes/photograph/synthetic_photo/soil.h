// Sand, clay and fine gravel: what lies between the stones and is not labeled.
#pragma once

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "nodes/photograph/synthetic_photo/palette.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

// Hills, crumbs, ledges, cracks, pits, the molds of lost stones, smooth places and layers of fine gravel.
void make_soil(Canvas&, const PhotoPalette&, Random&, const Work&);

// Fills hollows with smooth clay that climbs onto the stones around it and hides their feet.
void spread_clay(Canvas&, const PhotoPalette&, Random&, const Work&);

}  // namespace terrazzo::synthetic_photo

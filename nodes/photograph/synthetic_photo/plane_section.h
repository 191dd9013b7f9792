// Plane sections: profiles in a binder, as a saw, a polished face or a microscope shows them.
#pragma once

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "nodes/photograph/synthetic_photo/palette.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

enum class SectionKind {
  Mixed,   // particles in a binder
  Grown,   // as phases grow in a metal: lobed particles, fine ones between large ones, halos, scratches
  Joined,  // the same, of grains that grew together and left notches
};

struct SectionOptions {
  double fill = 0.5;  // area fraction aimed at, 0 to 1
  SectionKind kind = SectionKind::Mixed;
};

// Mixed: cells of a power diagram above a fill of about 0.6. Mixed and grown: shapes dropped one after the
// other where there is room, so that neighbors may touch.
void make_plane_section(Canvas&, const SectionOptions&, const PhotoPalette&, Random&, const Work&);

}  // namespace terrazzo::synthetic_photo

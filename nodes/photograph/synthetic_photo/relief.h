// Rough surfaces: soil with stones in it, or heaps of loose stones.
#pragma once

#include <vector>

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "nodes/photograph/synthetic_photo/palette.h"
#include "runtime/work.h"

namespace terrazzo::synthetic_photo {

struct ReliefOptions {
  bool heap = false;  // stones rest on each other and cover all soil
  double fill = 0.5;  // area of all stones / area of the picture, each seen alone
};

void make_relief(Canvas&, const ReliefOptions&, const PhotoPalette&, Random&, const Work&);

}  // namespace terrazzo::synthetic_photo

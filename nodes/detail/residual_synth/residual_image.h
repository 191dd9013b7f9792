// The residual of a photograph: its pixels minus their profile's mean color.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::residual_synth {

struct ResidualImage {
  Image image;                   // color offsets, mean 0 over all pixels
  Image means;                   // encoded: the mean color of each pixel's label
  Vec3f binder = Vec3f::Zero();  // mean of means over binder pixels, or over all pixels if there are none
  double filled = 0;             // fraction of pixels whose own value was not used
  double specks = 0;             // fraction of pixels labeled binder but with a different color
  int edge = 0;  // width of the excluded band in pixels; less than requested if too little would be left
};

// Converts the picture to a display's encoded values (sRGB). The paper's residuals are differences of these:
// in linear light the grain of bright particles would swamp that of dark ones.
Image as_displayed(const Image&, const Work& = {});

// Subtracts from each pixel the mean of its profile, and from binder pixels the binder mean of their section.
// Pixels within `edge` of another label are unreliable (antialiasing, halos, misplaced outlines): they do not
// enter the means and are filled by mirroring the residual at the nearest reliable pixel. The band shrinks
// until at least a tenth of the pixels is left. Binder pixels more than `specks` robust standard deviations
// from the binder's median (particles missed by the labels), and those within `edge` of them, are treated
// alike; 0 keeps them all. Throws Error "size-mismatch", "bad-pixels".
ResidualImage residual_image(const Image&, const Labels&, int edge, double specks = 0, const Work& = {});

}  // namespace terrazzo::residual_synth

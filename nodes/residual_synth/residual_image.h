// What is left of a photograph once every profile's mean colour is taken away.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo {

struct ResidualImage {
  Image image;                   // colour offsets, mean 0 over all pixels
  Image means;                   // encoded: the mean colour of each pixel's label
  Vec3f binder = Vec3f::Zero();  // mean of means over binder pixels, over all pixels where there are none
  double filled = 0;             // share of the pixels whose own value was not used
  double specks = 0;             // share that is binder by its label but not by its colour
  int edge = 0;  // the band left out, pixels: less than asked for where too little would have been left
};

// The picture in the encoded values of a display (sRGB), in which the paper's residuals are differences: in
// linear light the grain of bright particles would swamp dark ones.
Image as_displayed(const Image&, const Work& = {});

// Each pixel less the mean of its profile, binder pixels less their section's mean. Pixels within `edge` of
// another label belong to neither side (antialiasing, halos, misplaced outlines): they take no part in means
// and are filled by mirroring the residual at the nearest pixel that does. The band shrinks until a tenth of
// the pixels is left. The same befalls binder pixels more than `specks` robust standard deviations from the
// binder's median (particles that the labels miss) and those within `edge` of them; 0 keeps them all.
// Throws Error "size-mismatch", "bad-pixels".
ResidualImage residual_image(const Image&, const Labels&, int edge, double specks = 0, const Work& = {});

}  // namespace terrazzo

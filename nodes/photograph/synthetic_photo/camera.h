// From light to the file that a camera writes.
#pragma once

#include <vector>

#include "nodes/photograph/synthetic_photo/canvas.h"
#include "runtime/random.h"

namespace terrazzo::synthetic_photo {

struct Picture {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;  // encoded sRGB, 0 to 1
};

// Uneven light, exposure, white balance and defocus; then the average over 2 × 2 canvas pixels, encoded.
Picture expose(const Canvas&, const std::vector<Vec3f>& radiance, bool gray, Random&);
// Resampling, noise, sharpening, contrast and JPEG at random strengths, rounded to 8 bits.
void develop(Picture&, bool gray, Random&);

}  // namespace terrazzo::synthetic_photo

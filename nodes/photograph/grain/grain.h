// Mineral mottling and camera noise, so that a drawn section looks like a photographed one.
#pragma once

#include <cstdint>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::grain {

struct GrainOptions {
  double mottle = 0.15;  // standard deviation of the brightness within a particle, relative
  double vary = 0.05;    // standard deviation of the color channels between particles, relative
  double scale = 1;      // mm, size of the largest mottles
  double blur = 0.7;     // pixels, standard deviation of the lens blur
  double noise = 0.01;   // standard deviation of a pixel, linear, at mid gray; grows as √brightness
  std::uint64_t seed = 1;
};

// Every label gets its own mottles, so no pattern continues across an edge. Without labels the picture is one
// body. `labels`, if given, must have the image's size. Throws Error "empty-image", "size-mismatch".
Image add_grain(const Image&, const Labels* labels, const GrainOptions&, const Work&);

}  // namespace terrazzo::grain

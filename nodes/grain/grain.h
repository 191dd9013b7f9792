// Mineral mottling and camera noise, so that a drawn section looks like a photographed one.
#pragma once

#include <cstdint>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo {

struct GrainSettings {
  double mottle = 0.15;  // standard deviation of the brightness within a particle, relative
  double vary = 0.05;    // of one particle's colour channels against another's, relative
  double scale = 1;      // mm, size of the largest mottles
  double blur = 0.7;     // pixels, standard deviation of the lens
  double noise = 0.01;   // standard deviation of a pixel, linear, at mid grey; grows as √brightness
  std::uint64_t seed = 1;
};

// Every label gets mottles of its own (no pattern runs across an edge); without labels the picture is one
// body. `labels`, where given, are of the image's size.
Image add_grain(const Image&, const Labels* labels, const GrainSettings&, const Work&);

}  // namespace terrazzo

// From particle pixels to individual particles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/segment/color/figure_ground.h"
#include "nodes/photograph/segment/color/mosaic.h"

namespace terrazzo::segment {

struct SplitOptions {
  double strength = 0.5;  // 0 to 1, as in split_at_necks
  double min_area = -1;   // pixels; smaller parts are dropped; negative: automatic
};

struct Particles2D {
  std::vector<std::int32_t> labels;  // from 1
  std::vector<float> coverage;       // of each pixel
  double min_area = 0;               // pixels, the value used
  std::int64_t specks = 0;           // number of parts dropped as too small
  std::int64_t speck_pixels = 0;
  std::int64_t holes = 0;  // number of holes filled
};

// Classifies the pixels by cluster, refines the outline, fills small holes, drops specks, splits at necks and
// along borders of two distinct colors, and then fills holes within single particles.
Particles2D find_particles(const Mosaic&, const Ground&, const SplitOptions&, const Work&);

}  // namespace terrazzo::segment

// From particle pixels to single particles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/segment/figure_ground.h"
#include "nodes/segment/regions.h"

namespace terrazzo {

struct SplitOptions {
  double strength = 0.5;  // 0…1, as in split_at_necks
  double min_area = -1;   // pixels: smaller parts are dropped; negative: found
};

struct Particles2D {
  std::vector<std::int32_t> labels;  // from 1
  std::vector<float> coverage;       // of each pixel
  double min_area = 0;               // pixels, the one used
  std::int64_t specks = 0;           // parts dropped for their size
  std::int64_t speck_pixels = 0;
  std::int64_t holes = 0;  // holes filled
};

// Particle pixels by cluster, outline refined, small holes filled, specks dropped, parted at necks and along
// borders of two distinct colours, then holes filled that lie within one particle.
Particles2D find_particles(const Mosaic&, const Ground&, const SplitOptions&, const Work&);

// The regions of a photograph that look like particles by edge and shape (region_tree.h), for pictures whose
// colours do not part particles from binder.
Particles2D find_particles_by_regions(const Mosaic&, double likeness, const Vec3f* binder,
                                      const SplitOptions&, const Work&);

}  // namespace terrazzo

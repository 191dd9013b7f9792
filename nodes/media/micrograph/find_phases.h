// The phases of a micrograph from its gray levels: a hidden Markov random field (Zhang, Brady and Smith
// 2001).
#pragma once

#include <vector>

#include "nodes/data/image.h"
#include "nodes/media/micrograph/phase_map.h"
#include "runtime/work.h"

namespace terrazzo::media {

struct PhaseOptions {
  int phases = 0;        // 2 … kMostPhases; 0: as many as the histogram has peaks, at most 5
  double smoothing = 1;  // weight of equal neighbors
  bool shading = true;   // slow changes of light are removed
};

struct FoundPhases {
  PhaseMap map;                      // phases from dark to light, or in the order of strokes
  std::vector<double> level, noise;  // of each phase: mean and standard deviation along the axis of
                                     // display-encoded colors that differ most; gray is √3 times the level
  std::vector<Vec3f> color;          // mean, scene-linear
  double separation = 0;             // smallest distance between neighboring levels / the sum of their noise
  double uncertain = 0;              // share of pixels whose phase is less than 90 % sure
  double shading = 0;                // range of the light that was removed, in the units of `level`
};

// Peak memory in bytes, with unobserved_pixels.
double phases_forecast(const Image&);

// Pixels of the first section where `unobserved` is not 0 do not count; it may be empty. Throws Error
// "one-phase" if the histogram has a single peak, "bad-pixels", "empty-image".
FoundPhases find_phases(const Image&, const std::vector<std::uint8_t>& unobserved, const PhaseOptions&,
                        const Work&);

}  // namespace terrazzo::media

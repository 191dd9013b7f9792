// Heeger and Bergen's synthesis in three dimensions, by slice families.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/residual_synth/exemplar.h"

namespace terrazzo {

struct SynthReport {
  std::vector<double> deviation;  // per scale (high-pass, scales, low-pass): slices' σ / exemplar's, worst
                                  // axis and orientation, of the first colour axis
};

// A tileable volume of colour offsets with mean 0, x fastest: from noise of the exemplar's values, `rounds`
// times: on all slices of each axis every pyramid band gets the exemplar's distribution; the three results
// are averaged; voxels get the exemplar's values. Matching 3D bands to 2D ones instead would leave slices
// with wrong bands, since a slice projects frequencies across it into its plane. Heeger, Bergen 1995.
std::vector<Vec3f> synthesize_residual(const Exemplar&, const Vec3i& size, int rounds, std::uint64_t seed,
                                       SynthReport&, const Work& = {});

}  // namespace terrazzo

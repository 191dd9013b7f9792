// Heeger and Bergen's synthesis in three dimensions, by slice families.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/detail/residual_synth/exemplar.h"

namespace terrazzo::residual_synth {

// Returns a tileable volume of color offsets with mean 0, x fastest (Heeger, Bergen 1995). Starts from noise
// with the exemplar's spectrum. Each of `rounds` rounds matches every pyramid band of all slices across each
// axis to the exemplar's distribution, adds up the changes of the three axes, filters the bands' deviations
// back to the exemplar's, and matches the voxels to its values. Matching 3D bands to 2D ones instead would
// leave slices with wrong bands, since a slice projects frequencies across it into its plane.
std::vector<Vec3f> synthesize_residual(const Exemplar&, const Vec3i& size, int rounds, std::uint64_t seed,
                                       const Work& = {});

// Per scale (high-pass, scales, low-pass): standard deviation of the slices' band / the picture's, for the
// axis, orientation and color axis where it is farthest from 1. `exemplar` must be measured with four
// orientations.
std::vector<double> slice_deviations(const Exemplar&, const Vec3i& size, const std::vector<Vec3f>& voxels,
                                     const Work& = {});

}  // namespace terrazzo::residual_synth

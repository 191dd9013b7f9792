// Heeger and Bergen's synthesis in three dimensions, by slice families.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/residual_synth/exemplar.h"

namespace terrazzo {

// A tileable volume of colour offsets with mean 0, x fastest: from noise of the exemplar's spectrum, `rounds`
// times: on all slices of each axis every pyramid band gets the exemplar's distribution, the changes of the
// three axes are added up, filters bring the bands' deviations back to the exemplar's, and voxels get its
// values. Matching 3D bands to 2D ones instead would leave slices with wrong bands, since a slice projects
// frequencies across it into its plane. Heeger, Bergen 1995.
std::vector<Vec3f> synthesize_residual(const Exemplar&, const Vec3i& size, int rounds, std::uint64_t seed,
                                       const Work& = {});

// Per scale (high-pass, scales, low-pass): standard deviation of the slices' band / the picture's; of axes,
// orientations and colour axes the one furthest from 1. `exemplar` is measured with four orientations.
std::vector<double> slice_deviations(const Exemplar&, const Vec3i& size, const std::vector<Vec3f>& voxels,
                                     const Work& = {});

}  // namespace terrazzo

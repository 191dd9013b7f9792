// The initial noise of the synthesis: Gaussian, with the exemplar's band variances on its slices.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/common/texture/quantiles.h"
#include "nodes/common/texture/slice_family.h"
#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::residual_synth {

// Power of each band in a factor of the spectrum, per axis and band. The spectrum of the field is S(k) =
// Π_axis Σ_band factor[axis][band] · |transfer_band(k without the axis' component)|².
using PowerFactors = std::array<std::vector<double>, 3>;

// Fits factors such that slices across x, y and z have bands of these variances, by iterative proportional
// fitting on a polar grid of frequencies. A slice's spectrum is the volume's integrated along the axis, so
// the factors cannot be set separately.
PowerFactors fit_power(const std::array<const std::vector<Quantiles>*, 3>& bands, int scales);

// A periodic field with that spectrum, x fastest, its mean near 0. `families` holds the slices across x, y
// and z.
std::vector<float> start_field(const PowerFactors&, const Vec3i& size,
                               const std::vector<SliceFamily>& families, SliceFamily::Workspace&,
                               std::uint64_t seed, std::uint64_t stream, const Work&);

}  // namespace terrazzo::residual_synth

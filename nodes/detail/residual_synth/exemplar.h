// Statistics of residuals that the synthesis reproduces: color axes, value distribution, and the distribution
// of every pyramid band.
#pragma once

#include <array>
#include <vector>

#include "nodes/common/texture/quantiles.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::residual_synth {

struct Exemplar {
  int scales = 0;
  int channels = 0;               // principal color axes with variance, 0 … 3; 0 for a flat picture
  Mat3 axes = Mat3::Identity();   // columns, by falling variance
  std::vector<Quantiles> values;  // per channel, over all pictures assigned to an axis
  // Per picture, channel and band, in the order of pyramid_bands.
  std::vector<std::vector<std::vector<Quantiles>>> bands;
  std::array<int, 3> picture = {0, 0, 0};  // index of the picture for slices across x, y and z
  const std::vector<Quantiles>& wanted(int axis, int channel) const {
    return bands[static_cast<std::size_t>(picture[axis])][static_cast<std::size_t>(channel)];
  }
};

// Measures one to three residuals of mean 0; `orientations` as in pyramid_bands. Only their periodic
// component is measured (Moisan 2011), so that borders leave no cross in the spectrum. Pictures larger than
// 720² are cropped to their middle, and sizes to ones with fast transforms. At most 8 sections are used.
// Throws Error "image-too-small" below 16 pixels per side.
Exemplar measure_exemplar(const std::vector<Image>& residuals, const std::array<int, 3>& picture, int scales,
                          int orientations, const Work& = {});

}  // namespace terrazzo::residual_synth

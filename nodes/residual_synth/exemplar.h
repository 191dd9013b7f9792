// What the synthesis keeps of residuals: colour axes, value distribution, and the distribution of every
// pyramid band.
#pragma once

#include <array>
#include <vector>

#include "nodes/common/quantiles.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

struct Exemplar {
  int scales = 0;
  int channels = 0;               // principal colour axes with variance, 0 … 3; 0 for a flat picture
  Mat3 axes = Mat3::Identity();   // columns, by falling variance
  std::vector<Quantiles> values;  // per channel, of all pictures that an axis wants
  // Per picture, channel and band, in the order of pyramid_bands.
  std::vector<std::vector<std::vector<Quantiles>>> bands;
  std::array<int, 3> picture = {0, 0, 0};  // which one the slices across x, y and z are to look like
  const std::vector<Quantiles>& wanted(int axis, int channel) const {
    return bands[static_cast<std::size_t>(picture[static_cast<std::size_t>(axis)])]
                [static_cast<std::size_t>(channel)];
  }
};

// One to three residuals of mean 0; `orientations` as in pyramid_bands. Their periodic component is measured
// (Moisan 2011), so that borders leave no cross in the spectrum. Pictures larger than 720² are cut to their
// middle; sizes are cut to fast ones. At most 8 sections are used. Throws Error "image-too-small" below 16
// pixels a side.
Exemplar measure_exemplar(const std::vector<Image>& residuals, const std::array<int, 3>& picture, int scales,
                          int orientations, const Work& = {});

}  // namespace terrazzo

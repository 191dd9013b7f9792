// Statistics of an image in each band of a steerable pyramid.
#pragma once

#include <vector>

#include "nodes/common/texture/quantiles.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

struct BandStatistics {
  std::vector<Quantiles> values;  // per channel
  std::vector<double> deviation;  // per channel, of the periodic component, which is the sum of the bands
  std::vector<std::vector<Quantiles>> bands;  // per channel and band, in the order of pyramid_bands
  int width = 0, height = 0;                  // of the measured part
};

// Measures the first `channels` components of the pixels, whatever they represent. Uses the periodic
// component (Moisan 2011), so that the borders cause no cross in the spectrum. Larger images are cropped to a
// central part with 720² pixels over at most 8 sections, and to sizes with a fast FFT. `orientations` as in
// pyramid_bands. Needs at least 16 pixels per side.
BandStatistics measure_bands(const Image&, int channels, int scales, const Work& = {}, int orientations = 4);

}  // namespace terrazzo

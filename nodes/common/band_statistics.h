// What pictures hold in each band of a steerable pyramid.
#pragma once

#include <vector>

#include "nodes/common/quantiles.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

struct BandStatistics {
  std::vector<Quantiles> values;              // per channel
  std::vector<double> deviation;              // per channel, of the periodic component: what bands add up to
  std::vector<std::vector<Quantiles>> bands;  // per channel and band, in the order of pyramid_bands
  int width = 0, height = 0;                  // of the part measured
};

// Of the first `channels` components of an image's pixels, whatever they stand for. The periodic component is
// measured (Moisan 2011), so that borders leave no cross in the spectrum. Pictures larger than 720² are cut
// to their middle; `orientations` as in pyramid_bands; sizes are cut to fast ones. At most 8 sections are
// used. At least 16 pixels a side.
BandStatistics measure_bands(const Image&, int channels, int scales, const Work& = {}, int orientations = 4);

}  // namespace terrazzo

// What the synthesis keeps of a residual: colour axes, value distribution, and the distribution of every
// pyramid band.
#pragma once

#include <vector>

#include "nodes/common/quantiles.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

struct Exemplar {
  int scales = 0;
  int channels = 0;               // principal colour axes with variance, 0 … 3; 0 for a flat picture
  Mat3 axes = Mat3::Identity();   // columns, by falling variance
  std::vector<Quantiles> values;  // per channel
  std::vector<std::vector<Quantiles>> bands;  // per channel and band, in the order of pyramid_bands
  int width = 0, height = 0;                  // of the part measured
};

// `residual` has mean 0. Its periodic component is measured (Moisan 2011), so that borders leave no cross in
// the spectrum. Pictures larger than 720² are cut to their middle; sizes are cut to fast ones. At most 8
// sections are used. Throws Error "image-too-small" below 16 pixels a side.
Exemplar measure_exemplar(const Image& residual, int scales, const Work& = {});

}  // namespace terrazzo

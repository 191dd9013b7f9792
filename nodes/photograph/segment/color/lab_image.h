// One section in Oklab, and its noise.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/indices.h"
#include "runtime/work.h"

namespace terrazzo::segment {

struct LabImage {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;  // Oklab, row by row from the top
  std::size_t index(int x, int y) const { return pixel_at(x, y, width); }
};

LabImage lab_section(const Image&, int section, const Work&);

// Standard deviation of the lightness noise: the median of |Immerkær's Laplacian difference| (Immerkær 1996,
// with the median instead of the mean, to ignore edges). Fine texture counts as noise.
float noise_of(const LabImage&);

// Edge-stopping diffusion (Perona and Malik 1990, second flux) of color vectors. Flattens differences below
// `contrast` (Oklab distance) between neighbors over about √(2·rounds·0.2) pixels and keeps edges above it.
LabImage diffuse(LabImage, float contrast, int rounds, const Work&);

// Component-wise 3 × 3 median.
LabImage median3(const LabImage&, const Work&);

// Gaussian blur with standard deviation `sigma` in pixels, mirrored at the border.
LabImage blur(LabImage, float sigma, const Work&);
void blur_in_place(const cv::Mat& floats, float sigma, const Work&);

}  // namespace terrazzo::segment

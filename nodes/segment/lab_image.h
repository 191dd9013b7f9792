// One section in Oklab, and its noise.
#pragma once

#include <vector>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo {

struct LabImage {
  int width = 0, height = 0;
  std::vector<Vec3f> pixels;  // Oklab, in reading order
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};

LabImage lab_section(const Image&, int section, const Work&);

// Standard deviation of the noise in lightness: median of |Immerkær's Laplacian difference| (Immerkær 1996,
// with the median in the place of the mean, so that edges do not count). Fine texture counts as noise.
float noise_of(const LabImage&);

// Edge-stopping diffusion (Perona and Malik 1990, second flux) on colour vectors: flattens what varies by
// less than `contrast` (Oklab distance) between neighbours over about √(2·rounds·0.2) pixels, and keeps edges
// above it.
LabImage diffuse(LabImage, float contrast, int rounds, const Work&);

// Component-wise median of 3 × 3.
LabImage median3(const LabImage&, const Work&);

// Gaussian of standard deviation `sigma` pixels, mirrored at the border.
LabImage blur(const LabImage&, float sigma, const Work&);

}  // namespace terrazzo

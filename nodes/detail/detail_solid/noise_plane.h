// A photograph as noise is measured in it: in channels, with blocks and their cosine transform.
#pragma once

#include <Eigen/Dense>

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

constexpr int kBlock = 16;                    // pixels, edge of a block
constexpr int kLightness = 32;                // levels of lightness, 0 to 1
constexpr std::size_t kCheckEvery = 1 << 20;  // pixels between checks for cancellation

using Block = Eigen::Matrix<float, kBlock, kBlock, Eigen::RowMajor>;
using Channels = std::array<std::vector<float>, 3>;

// One section of a photograph in the channels of residual::noise_axes, and the pixels far enough from
// outlines.
struct Plane {
  int width = 0, height = 0;
  bool gray = false;
  Channels channel;
  std::vector<std::int32_t> place;  // the label + 1; 0: not used

  int channels() const { return gray ? 1 : 3; }
  // The orthonormal cosine transform of the block whose upper left pixel is (x, y).
  Block block(int c, int x, int y) const;
  // Whether all pixels of a block are used and of one label.
  bool even(int x, int y) const;
};

// `mask`: not 0 where pixels are not used, may be null; `softness`: of outlines, pixels; `gray`: only the
// first channel is filled.
Plane plane_of(const Image&, const Labels&, const Labels* mask, int section, bool gray, double softness,
               const Work& = {});

// The block with these coefficients.
Block pixels_of(const Block& coefficients);
// The lightness of a block of the first channel.
float lightness_of(const Block& coefficients);
// The level of a lightness.
int level_of(float lightness);

}  // namespace terrazzo::detail_solid

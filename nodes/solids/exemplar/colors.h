// The color axes in which the synthesis works.
#pragma once

#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::solids {

// Principal axes of the exemplars' colors, all divided by one number that makes their total variance 1.
// Distances keep their ratios. The channels are uncorrelated, so that matching their histograms separately
// makes no new colors.
struct ColorAxes {
  bool lab = true;   // Oklab, else scene-linear Rec. 709
  int channels = 0;  // channels with significant variance, 0 … 3
  Vec3f mean = Vec3f::Zero();
  Mat3 axes = Mat3::Identity();  // columns, by falling variance
  float scale = 1;

  Vec3f to(const Vec3f& linear) const;
  Vec3f from(const Vec3f& working) const;  // scene-linear, clamped at 0
};

// The axes of all pictures together, each with equal weight.
ColorAxes color_axes(const std::vector<const std::vector<Vec3f>*>& linear, bool lab);

}  // namespace terrazzo::solids

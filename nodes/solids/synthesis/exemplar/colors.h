// The color axes in which the synthesis works.
#pragma once

#include <vector>

#include "nodes/data/linear.h"
#include "nodes/solids/synthesis/options/solid_options.h"

namespace terrazzo::solids {

// Axes of the exemplars' colors, all divided by one number that makes their total variance 1. Distances keep
// their ratios. In Lab and Linear these are the principal axes: the channels are uncorrelated, so that
// matching their histograms separately makes no new colors. In Rgb they are the channels as stored, by
// falling variance (Laursen et al. 2011, section 4.4).
struct ColorAxes {
  SolidColor color = SolidColor::Lab;
  int channels = 0;  // channels with significant variance, 0 … 3
  Vec3f mean = Vec3f::Zero();
  Mat3 axes = Mat3::Identity();  // columns, by falling variance
  float scale = 1;

  Vec3f to(const Vec3f& linear) const;
  Vec3f from(const Vec3f& working) const;  // scene-linear, clamped at 0
};

// The axes of all pictures together, each with equal weight.
ColorAxes color_axes(const std::vector<const std::vector<Vec3f>*>& linear, SolidColor);

}  // namespace terrazzo::solids

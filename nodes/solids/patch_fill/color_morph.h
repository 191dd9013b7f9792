// The colors between two solids: a working space in which both have the same distribution, and the way back.
#pragma once

#include <array>
#include <vector>

#include "nodes/common/texture/quantiles.h"
#include "nodes/data/linear.h"

namespace terrazzo::patch_fill {

// Each solid has its own principal axes in Oklab. Along the k-th axis, a value's rank in its solid decides
// which value of the other solid corresponds to it (one-dimensional optimal transport). The working value of
// a rank lies halfway between the two values, each divided by the standard deviation of its solid's colors.
class ColorMorph {
 public:
  // Scene-linear colors. Throws Error "one-color" if all colors of a solid are equal.
  ColorMorph(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b);

  // The working value of a color of solid 0 (a) or 1 (b).
  Vec3f to_working(int solid, const Vec3f& linear) const;
  // The color at weight w: that of a for 0, that of b for 1. Between, it moves on a straight line in Oklab.
  Vec3f to_linear(const Vec3f& working, float w) const;
  // The distribution of the k-th working values, the same for both solids.
  const Quantiles& working(int k) const { return working_[k]; }

 private:
  struct Solid {
    Vec3f mean = Vec3f::Zero();
    Mat3 axes;  // columns
    double deviation = 0;
    std::array<Quantiles, 3> values;
  };
  static Solid measure(const std::vector<Vec3f>& colors, const char* name);
  std::array<Solid, 2> solid_;
  std::array<Quantiles, 3> working_;
};

}  // namespace terrazzo::patch_fill

#include "nodes/solids/exemplar/colors.h"

#include <cmath>

#include "nodes/common/geometry/principal_axes.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::solids {

Vec3f ColorAxes::to(const Vec3f& linear) const {
  return axes.cast<float>().transpose() * ((lab ? linear_to_oklab(linear) : linear) - mean) * scale;
}

Vec3f ColorAxes::from(const Vec3f& working) const {
  const Vec3f c = axes.cast<float>() * (working / scale) + mean;
  return (lab ? oklab_to_linear(c) : c).cwiseMax(0.0f);
}

ColorAxes color_axes(const std::vector<const std::vector<Vec3f>*>& linear, bool lab) {
  ColorAxes out;
  out.lab = lab;
  Vec3 mean = Vec3::Zero();
  Mat3 square = Mat3::Zero();
  for (const auto* picture : linear) {
    Vec3 m = Vec3::Zero();
    Mat3 s = Mat3::Zero();
    for (const auto& p : *picture) {
      const Vec3 c = (lab ? linear_to_oklab(p) : p).cast<double>();
      m += c, s += c * c.transpose();
    }
    const double share = 1.0 / (static_cast<double>(picture->size()) * static_cast<double>(linear.size()));
    mean += share * m, square += share * s;
  }
  const auto solver = eigen_axes(Mat3(square - mean * mean.transpose()));
  const double total = solver.eigenvalues().cwiseMax(0).sum();
  out.mean = mean.cast<float>();
  out.axes = principal_axes(solver);
  for (int c = 0; c < 3; ++c) {
    const double variance = solver.eigenvalues()[2 - c];
    if (variance > 1e-12 && variance > 1e-5 * total) out.channels = c + 1;
  }
  if (out.channels > 0) out.scale = static_cast<float>(1 / std::sqrt(total));
  return out;
}

}  // namespace terrazzo::solids

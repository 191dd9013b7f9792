#include "nodes/solids/synthesis/exemplar/colors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::solids {

namespace {

Vec3f encoded(const Vec3f& linear, SolidColor color) {
  switch (color) {
    case SolidColor::Lab:
      return linear_to_oklab(linear);
    case SolidColor::Rgb:
      return linear_to_srgb(linear);
    default:
      return linear;
  }
}

Vec3f decoded(const Vec3f& c, SolidColor color) {
  switch (color) {
    case SolidColor::Lab:
      return oklab_to_linear(c);
    case SolidColor::Rgb:
      return srgb_to_linear(c);
    default:
      return c;
  }
}

struct Axes {
  Vec3 variance;  // falling
  Mat3 columns;
  double total = 0;  // variance
};

Axes principal(const Mat3& covariance) {
  const auto solver = eigen_axes(covariance);
  return {solver.eigenvalues().reverse(), principal_axes(solver), solver.eigenvalues().cwiseMax(0).sum()};
}

Axes stored_channels(const Mat3& covariance) {
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return covariance(a, a) > covariance(b, b); });
  Axes out{Vec3::Zero(), Mat3::Zero(), covariance.trace()};
  for (int c = 0; c < 3; ++c) {
    out.variance[c] = covariance(order[c], order[c]);
    out.columns(order[c], c) = 1;
  }
  return out;
}

}  // namespace

Vec3f ColorAxes::to(const Vec3f& linear) const {
  return axes.cast<float>().transpose() * (encoded(linear, color) - mean) * scale;
}

Vec3f ColorAxes::from(const Vec3f& working) const {
  const Vec3f c = axes.cast<float>() * (working / scale) + mean;
  return decoded(c, color).cwiseMax(0.0f);
}

ColorAxes color_axes(const std::vector<const std::vector<Vec3f>*>& linear, SolidColor color) {
  ColorAxes out;
  out.color = color;
  Vec3 mean = Vec3::Zero();
  Mat3 square = Mat3::Zero();
  for (const auto* picture : linear) {
    Vec3 m = Vec3::Zero();
    Mat3 s = Mat3::Zero();
    for (const auto& p : *picture) {
      const Vec3 c = encoded(p, color).cast<double>();
      m += c;
      s += c * c.transpose();
    }
    const double share = 1.0 / (static_cast<double>(picture->size()) * linear.size());
    mean += share * m;
    square += share * s;
  }
  const Mat3 covariance = square - mean * mean.transpose();
  const Axes axes = color == SolidColor::Rgb ? stored_channels(covariance) : principal(covariance);
  out.mean = mean.cast<float>();
  out.axes = axes.columns;
  for (int c = 0; c < 3; ++c)
    if (axes.variance[c] > 1e-12 && axes.variance[c] > 1e-5 * axes.total) out.channels = c + 1;
  if (out.channels > 0) out.scale = 1 / std::sqrt(axes.total);
  return out;
}

}  // namespace terrazzo::solids

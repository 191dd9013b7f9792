#include "nodes/media/micrograph/gray_picture.h"

#include <fmt/format.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"

namespace terrazzo::media {
namespace {

constexpr double kLeastNoise = 0.002;  // half a step of 8 bits

// The direction in which colors differ most, towards light.
Vec3 main_axis(const std::vector<Vec3f>& color, const std::vector<std::uint8_t>& in) {
  Vec3 mean = Vec3::Zero();
  double n = 0;
  for (std::size_t i = 0; i < color.size(); ++i)
    if (in[i]) {
      mean += color[i].cast<double>();
      ++n;
    }
  mean /= n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < color.size(); ++i)
    if (in[i]) {
      const Vec3 d = color[i].cast<double>() - mean;
      covariance += d * d.transpose();
    }
  Vec3 axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors().col(2);
  if (axis.sum() < 0) axis = -axis;
  return axis;
}

}  // namespace

GrayPicture gray_picture(const Image& image, const std::vector<std::uint8_t>& unobserved) {
  GrayPicture out{image.width, image.height, cv::Mat1f(image.height, image.width), {}, {}};
  const std::size_t n = pixels_in(image.width, image.height);
  if (n == 0) throw Error("empty-image", "the image has no pixels", "connect an image");
  out.in.assign(n, 1);
  std::vector<Vec3f> color(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!unobserved.empty() && unobserved[i]) out.in[i] = 0;
    if (!image.pixels[i].allFinite())
      throw Error("bad-pixels",
                  fmt::format("a color is NaN or infinite at ({}, {})", i % image.width, i / image.width),
                  "replace the bad pixels in the picture");
    color[i] = linear_to_srgb(image.pixels[i]);
  }
  if (std::count(out.in.begin(), out.in.end(), 1) == 0)
    throw Error("empty-image", "no pixel of the image is observed", "connect a smaller mask");
  const Vec3f axis = main_axis(color, out.in).cast<float>();
  for (std::size_t i = 0; i < n; ++i) out.gray.ptr<float>()[i] = axis.dot(color[i]);
  out.light = cv::Mat1f::zeros(image.height, image.width);
  return out;
}

void measure(const GrayPicture& p, const std::vector<std::uint8_t>& label, PhaseLevels& out) {
  const std::size_t phases = out.level.size();
  std::vector<double> sum(phases, 0), squares(phases, 0), n(phases, 0);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      if (!p.observed(x, y)) continue;
      const std::uint8_t k = label[pixel_at(x, y, p.width)];
      const double g = p.at(x, y);
      sum[k] += g;
      squares[k] += g * g;
      ++n[k];
    }
  for (std::size_t k = 0; k < phases; ++k) {
    if (n[k] == 0) continue;
    out.level[k] = sum[k] / n[k];
    out.noise[k] =
        std::max(kLeastNoise, std::sqrt(std::max(0.0, squares[k] / n[k] - out.level[k] * out.level[k])));
  }
}

double separation(const PhaseLevels& levels) {
  double out = 1e300;
  for (std::size_t k = 1; k < levels.level.size(); ++k)
    out = std::min(out, (levels.level[k] - levels.level[k - 1]) / (levels.noise[k] + levels.noise[k - 1]));
  return out;
}

FoundPhases summary(const Image& image, const GrayPicture& p, const std::vector<std::uint8_t>& label,
                    const PhaseLevels& levels) {
  const int phases = count_of(levels.level);
  FoundPhases out;
  out.level = levels.level;
  out.noise = levels.noise;
  out.map = {p.width, p.height, phases, image.pixel_size, label};
  out.color.assign(phases, Vec3f::Zero());
  std::vector<double> n(phases, 0);
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (!p.in[i]) {
      out.map.at[i] = kUnobserved;
      continue;
    }
    out.color[label[i]] += image.pixels[i];
    ++n[label[i]];
  }
  for (int k = 0; k < phases; ++k)
    if (n[k] > 0) out.color[k] /= static_cast<float>(n[k]);
  out.separation = separation(levels);
  double low = 0, high = 0;
  cv::minMaxLoc(p.light, &low, &high);
  out.shading = high - low;
  return out;
}

}  // namespace terrazzo::media

#include "nodes/photograph/segment/color/delight.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "nodes/common/geometry/rank.h"
#include "nodes/data/indices.h"
#include "nodes/data/luminance.h"
#include "nodes/photograph/segment/color/split.h"
#include "nodes/photograph/segment/measure/pixel_lists.h"

namespace terrazzo::segment {
namespace {

// Logarithm of the uneven light on a small copy, mean 0.
cv::Mat uneven_light(const Image& image, int section, const std::int32_t* ids, const IgnoredPixels& ignored,
                     float binder, float particles) {
  const double scale = std::min(1.0, 256.0 / std::max(image.width, image.height));
  const int w = std::max<int>(1, image.width * scale), h = std::max<int>(1, image.height * scale);
  cv::Mat sum(h, w, CV_32F, cv::Scalar(0)), weight(h, w, CV_32F, cv::Scalar(0));
  const std::size_t before = image.index(0, 0, section);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t i = pixel_at(x, y, image.width);
      if (!ignored.empty() && ignored[before + i]) continue;
      const int u = std::min<int>(w - 1, x * scale), v = std::min<int>(h - 1, y * scale);
      const float share = ids[i] > 0 ? 0.1f : 1.0f;
      sum.at<float>(v, u) += share * (std::log(std::max(1e-3f, luminance_of(image.pixels[before + i]))) -
                                      (ids[i] > 0 ? particles : binder));
      weight.at<float>(v, u) += share;
    }
  const double sigma = std::max(w, h) / 8.0;
  cv::GaussianBlur(sum, sum, cv::Size(0, 0), sigma, sigma, cv::BORDER_REFLECT);
  cv::GaussianBlur(weight, weight, cv::Size(0, 0), sigma, sigma, cv::BORDER_REFLECT);
  cv::Mat light = sum / cv::max(weight, 1e-6);
  light -= cv::mean(light)[0];
  return light;
}

// Least squares with Huber's weights, so that highlights, specks and veins don't bend the fit.
Eigen::Vector4d fit_shading(const std::vector<Eigen::Vector4d>& basis, const std::vector<float>& light,
                            float middle, float spread) {
  const std::size_t n = basis.size();
  Eigen::Vector4d fit(middle, 0, 0, 0);
  for (int round = 0; round < 4; ++round) {
    Eigen::Matrix4d a = 1e-6 * n * Eigen::Matrix4d::Identity();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < n; ++k) {
      const double off = std::abs(light[k] - basis[k].dot(fit)), share = off > spread ? spread / off : 1;
      a += share * basis[k] * basis[k].transpose();
      b += share * light[k] * basis[k];
    }
    fit = a.ldlt().solve(b);
  }
  return fit;
}

// Evens out the shading of one particle.
void flatten(Vec3f* pixels, std::span<const std::int32_t> places, int width,
             const std::vector<float>& depth2) {
  const std::size_t n = places.size();
  constexpr std::size_t kSmallest = 60;
  if (n < kSmallest) return;
  double cx = 0, cy = 0;
  float deepest = 0;
  std::vector<float> light(n);
  for (std::size_t k = 0; k < n; ++k) {
    cx += places[k] % width;
    cy += places[k] / width;
    deepest = std::max(deepest, std::sqrt(depth2[places[k]]));
    light[k] = luminance_of(pixels[places[k]]);
  }
  cx /= n;
  cy /= n;
  const double radius = std::sqrt(n / 3.14159);
  const float middle = median(light);
  if (!(middle > 1e-4f)) return;
  std::vector<float> away(n);
  for (std::size_t k = 0; k < n; ++k) away[k] = std::abs(light[k] - middle);
  const float spread = std::max(0.02f * middle, 1.4826f * median(away));

  std::vector<Eigen::Vector4d> basis(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double d = std::sqrt(depth2[places[k]]) / deepest;
    basis[k] = {1, (places[k] % width - cx) / radius, (places[k] / width - cy) / radius,
                std::sqrt(d * (2 - d))};
  }
  const Eigen::Vector4d fit = fit_shading(basis, light, middle, spread);
  double before = 0, after = 0;
  std::vector<float> values(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double value = basis[k].dot(fit), cap = 3.0 * spread;
    before += std::pow(std::clamp<double>(light[k] - middle, -cap, cap), 2);
    after += std::pow(std::clamp<double>(light[k] - value, -cap, cap), 2);
    values[k] = value;
  }
  const double level = std::max<double>(1e-4, median(std::move(values)));
  const double explained = before > 0 ? 1 - after / before : 0,
               trust = std::clamp((explained - 0.1) / 0.3, 0.0, 1.0);
  std::vector<float> even(n);
  std::vector<float> channel[3];
  for (std::size_t k = 0; k < n; ++k) {
    Vec3f& c = pixels[places[k]];
    const double factor = level / std::clamp(basis[k].dot(fit), 0.35 * level, 2.5 * level);
    c *= static_cast<float>(1 + trust * (factor - 1));
    even[k] = luminance_of(c);
    for (int j = 0; j < 3; ++j) channel[j].push_back(c[j]);
  }
  const Vec3f usual(median(channel[0]), median(channel[1]), median(channel[2]));
  const float bright = median(even);
  for (std::size_t k = 0; k < n; ++k) away[k] = std::abs(even[k] - bright);
  const float limit = bright + 4 * std::max(0.05f * bright, 1.4826f * median(away));
  for (std::size_t k = 0; k < n; ++k)
    if (even[k] > limit) pixels[places[k]] = usual;
}

}  // namespace

Image delight(const Image& photo, const Labels& labels, const IgnoredPixels& ignored, const Work& work) {
  Image out = photo;
  const std::size_t size = pixels_in(photo.width, photo.height);
  for (int section = 0; section < photo.sections; ++section) {
    work.check();
    const std::size_t before = size * section;
    const std::int32_t* ids = labels.ids.data() + before;
    const PixelLists lists(std::span(ids, size));

    // Particles and binder differ in color, so each of the two is compared with its own median.
    std::vector<float> light[2];
    constexpr std::size_t kEvery = 7;  // pixels; a sample is enough for a median
    for (std::size_t i = 0; i < size; i += kEvery)
      if (ignored.empty() || !ignored[before + i])
        light[ids[i] > 0].push_back(std::log(std::max(1e-3f, luminance_of(photo.pixels[before + i]))));
    const auto middle = [](const std::vector<float>& v) { return v.empty() ? 0.0f : median(v); };
    const cv::Mat field = uneven_light(photo, section, ids, ignored, middle(light[0]), middle(light[1]));
    cv::Mat full;
    cv::resize(field, full, cv::Size(photo.width, photo.height), 0, 0, cv::INTER_LINEAR);
    for (std::size_t i = 0; i < size; ++i) out.pixels[before + i] *= std::exp(-full.ptr<float>()[i]);
    full.release();

    const std::vector<float> depth2 =
        squared_distance({ids, ids + size}, photo.width, photo.height, false, work.quiet());
    work.parallel(lists.count(), 16, [&](std::size_t b, std::size_t e) {
      for (std::size_t k = b; k < e; ++k)
        flatten(out.pixels.data() + before, lists.of(k), photo.width, depth2);
    });
  }
  return out;
}

}  // namespace terrazzo::segment

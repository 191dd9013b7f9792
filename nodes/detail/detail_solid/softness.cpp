#include "nodes/detail/detail_solid/softness.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"

namespace terrazzo::detail_solid {
namespace {

constexpr int kStep = 8;  // pixels on each side of an outline

// The step of colors across outlines, in bins by the distance from the nearest outline.
struct OutlineSteps {
  std::array<double, 2 * kStep> up{}, down{};
};

// Adds one section. `flat` and `count` are sums of colors and pixels, of profiles and of each section's
// binder.
void add_outline_steps(const Image& image, const Labels& labels, int section, std::vector<Vec3>& flat,
                       std::vector<double>& count, OutlineSteps& steps) {
  const int w = image.width, h = image.height;
  const std::size_t plane = pixels_in(w, h);
  std::vector<Vec3f> encoded(plane);
  flat[0].setZero();
  count[0] = 0;
  cv::Mat particles(h, w, CV_8U), binder(h, w, CV_8U);
  const auto id = [&](std::size_t i) { return labels.ids[section * plane + i]; };
  for (std::size_t i = 0; i < plane; ++i) {
    encoded[i] = linear_to_srgb(image.pixels[section * plane + i].cwiseMax(0.0f));
    flat[id(i)] += encoded[i].cast<double>();
    ++count[id(i)];
    particles.data[i] = id(i) > 0 ? 0 : 255;
    binder.data[i] = id(i) > 0 ? 255 : 0;
  }
  cv::Mat outside, inside, nearest;
  cv::distanceTransform(particles, outside, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  cv::distanceTransform(binder, inside, cv::DIST_L2, cv::DIST_MASK_5);
  std::vector<std::int32_t> owner(plane + 1, 0);  // label of each number in `nearest`
  for (std::size_t i = 0; i < plane; ++i)
    if (id(i) > 0) owner[reinterpret_cast<const std::int32_t*>(nearest.data)[i]] = id(i);
  for (std::size_t i = 0; i < plane; ++i) {
    const float out = reinterpret_cast<const float*>(outside.data)[i],
                in = reinterpret_cast<const float*>(inside.data)[i];
    const double d = id(i) > 0 ? in - 0.5 : 0.5 - out;  // positive within particles
    const int bin = round_down(d) + kStep;
    if (bin < 0 || bin >= 2 * kStep) continue;
    const std::size_t k = owner[reinterpret_cast<const std::int32_t*>(nearest.data)[i]];
    if (!(count[k] > 0) || !(count[0] > 0)) continue;
    const Vec3 base = flat[0] / count[0], rise = flat[k] / count[k] - base;
    steps.up[bin] += (encoded[i].cast<double>() - base).dot(rise);
    steps.down[bin] += rise.squaredNorm();
  }
}

}  // namespace

double outline_softness(const Image& image, const Labels& labels) {
  std::vector<Vec3> flat(labels.count() + 1, Vec3::Zero());
  std::vector<double> count(flat.size(), 0.0);
  OutlineSteps steps;
  for (int section = 0; section < image.sections; ++section)
    add_outline_steps(image, labels, section, flat, count, steps);
  std::array<double, 2 * kStep> step{};
  for (std::size_t k = 0; k < step.size(); ++k) {
    if (!(steps.down[k] > 0)) return 0;
    step[k] = steps.up[k] / steps.down[k];
  }
  const double low = step.front(), high = step.back();
  if (!(high - low > 0.1)) return 0;  // particles and binder cannot be told by color
  // From where a quarter of the step is left behind to three quarters, around its middle.
  const auto share = [&](std::size_t k) { return (step[k] - low) / (high - low); };
  std::size_t middle = 1;
  while (middle + 1 < step.size() && share(middle) < 0.5) ++middle;
  const auto crossing = [&](double level) {
    std::size_t k = middle;
    if (level < 0.5)
      while (k > 1 && share(k - 1) > level) --k;
    else
      while (k + 1 < step.size() && share(k) < level) ++k;
    const double from = share(k - 1), to = share(k);
    return static_cast<double>(k) - 1 + std::clamp((level - from) / std::max(to - from, 1e-6), 0.0, 1.0);
  };
  const double sigma = (crossing(0.75) - crossing(0.25)) / 1.349;
  return std::clamp(std::sqrt(std::max(0.0, sigma * sigma - 1.0 / 6)), 0.0, 3.0);
}

}  // namespace terrazzo::detail_solid

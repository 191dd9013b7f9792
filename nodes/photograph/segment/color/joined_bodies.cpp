#include "nodes/photograph/segment/color/joined_bodies.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/rank.h"

namespace terrazzo::segment {
namespace {

constexpr double kFree = 0.6;                     // share of a further part that the others do not cover
constexpr double kGap = 1.0 / 3, kBeyond = 1.25;  // of the way from the parts' color to the binder's
constexpr double kAside = 0.5;                    // the same, across
constexpr double kLeastRest = 0.1;                // of the body, for a color that noise does not decide

struct Sum {
  Vec3 color = Vec3::Zero();
  double pixels = 0;
  void add(const Vec3f& c) {
    color += c.cast<double>();
    ++pixels;
  }
  Vec3 mean() const { return color / std::max(1.0, pixels); }
};

Vec3 median_color(const LabImage& image, const std::vector<std::int32_t>& labels) {
  Vec3 out = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    for (std::size_t i = 0; i < labels.size(); ++i)
      if (labels[i] == 0) values.push_back(image.pixels[i][axis]);
    if (!values.empty()) out[axis] = at_rank(values, values.size() / 2);
  }
  return out;
}

// The largest distance of what the parts leave of each body to anything else.
std::vector<double> widths_of_rest(const LabImage& image, const std::vector<std::int32_t>& labels,
                                   std::int32_t count, const std::vector<std::uint8_t>& covered) {
  cv::Mat rest(image.height, image.width, CV_8U), depth;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t i = image.index(x, y);
      const bool inner =
          (x == 0 || labels[i - 1] == labels[i]) && (y == 0 || labels[i - image.width] == labels[i]);
      rest.at<std::uint8_t>(y, x) = labels[i] > 0 && !covered[i] && inner;
    }
  cv::distanceTransform(rest, depth, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  std::vector<double> widths(count + 1, 0);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      double& width = widths[labels[image.index(x, y)]];
      width = std::max<double>(width, depth.at<float>(y, x));
    }
  return widths;
}

}  // namespace

std::vector<bool> joined_bodies(const LabImage& image, const std::vector<std::int32_t>& labels,
                                std::int32_t count, const std::vector<Instance>& instances,
                                const Work& work) {
  const Vec3 binder = median_color(image, labels);
  std::vector<std::size_t> order(instances.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return instances[a].score > instances[b].score; });
  const auto parts = instances_within(labels, count, instances, order, work);
  // Parts side by side: each is mostly free of the better ones.
  std::vector<std::uint8_t> covered(labels.size(), 0);
  std::vector<int> beside(count + 1, 0);
  for (std::int32_t id = 1; id <= count; ++id)
    for (const std::size_t k : parts[id - 1]) {
      const auto& pixels = instances[k].pixels;
      const auto taken = std::count_if(pixels.begin(), pixels.end(), [&](auto i) { return covered[i] != 0; });
      if (taken > (1 - kFree) * pixels.size()) continue;
      for (const auto i : pixels) covered[i] = 1;
      ++beside[id];
    }
  std::vector<Sum> within(count + 1), rest(count + 1);
  for (std::size_t i = 0; i < labels.size(); ++i)
    (covered[i] ? within : rest)[labels[i]].add(image.pixels[i]);
  const std::vector<double> widths = widths_of_rest(image, labels, count, covered);
  std::vector<bool> joined(count, false);
  for (std::int32_t id = 1; id <= count; ++id) {
    if (beside[id] < 2 || rest[id].pixels < kLeastRest * (rest[id].pixels + within[id].pixels)) continue;
    // A gap is narrower than the particles beside it.
    if (widths[id] > std::sqrt(within[id].pixels / (std::numbers::pi * beside[id]))) continue;
    const Vec3 to_binder = binder - within[id].mean();
    const Vec3 to_rest = rest[id].mean() - within[id].mean();
    const double way = to_rest.dot(to_binder) / std::max(to_binder.squaredNorm(), 1e-12);
    joined[id - 1] =
        way >= kGap && way <= kBeyond && (to_rest - way * to_binder).norm() <= kAside * to_binder.norm();
  }
  return joined;
}

}  // namespace terrazzo::segment

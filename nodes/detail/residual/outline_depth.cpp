#include "nodes/detail/residual/outline_depth.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"

namespace terrazzo::residual {

Outlines nearest_outlines(const std::int32_t* ids, int width, int height, bool wrap) {
  constexpr int kMargin = 32;      // of the repeated picture, where edges join
  constexpr double kSmooth = 1.5;  // pixels over which normals are smoothed
  const int margin = wrap ? kMargin : 0, w = width + 2 * margin, h = height + 2 * margin;
  const auto id = [&](int x, int y) {
    x = (x - margin + kMargin * width) % width;
    y = (y - margin + kMargin * height) % height;
    return ids[pixel_at(x, y, width)];
  };
  cv::Mat inside(h, w, CV_8U, cv::Scalar(255)), distance, nearest;
  cv::Mat particle(h, w, CV_32S, cv::Scalar(0));  // of pixels at an outline
  bool any = false;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const auto differ = [&](int u, int v) {
        if (u >= w || v >= h) return;
        const std::int32_t a = id(x, y), b = id(u, v);
        if (a == b) return;
        inside.at<std::uint8_t>(y, x) = inside.at<std::uint8_t>(v, u) = 0;
        auto &of_a = particle.at<std::int32_t>(y, x), &of_b = particle.at<std::int32_t>(v, u);
        of_a = a > 0 ? a : std::max(of_a, b);
        of_b = b > 0 ? b : std::max(of_b, a);
        any = true;
      };
      differ(x + 1, y);
      differ(x, y + 1);
    }
  const std::size_t pixels = pixels_in(width, height);
  Outlines out;
  if (!any) {
    out.depth.assign(pixels, static_cast<float>(std::hypot(width, height)));
    out.particle.assign(ids, ids + pixels);
    out.normal.assign(pixels, Eigen::Vector2f::Zero());
    return out;
  }
  cv::distanceTransform(inside, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<std::int32_t> owner(static_cast<std::size_t>(w) * h + 1, 0);  // of each number in `nearest`
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      if (inside.at<std::uint8_t>(y, x) == 0)
        owner[nearest.at<std::int32_t>(y, x)] = particle.at<std::int32_t>(y, x);
  out.depth.resize(pixels);
  out.particle.resize(pixels);
  out.normal.resize(pixels);
  cv::Mat depth(h, w, CV_32F);  // positive within particles
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const float d = distance.at<float>(y, x) + 0.5f;
      depth.at<float>(y, x) = id(x, y) > 0 ? d : -d;
    }
  cv::GaussianBlur(depth, depth, {0, 0}, kSmooth, kSmooth, cv::BORDER_REPLICATE);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i = pixel_at(x, y, width);
      out.depth[i] = distance.at<float>(y + margin, x + margin) + 0.5f;
      out.particle[i] = ids[i] > 0 ? ids[i] : owner[nearest.at<std::int32_t>(y + margin, x + margin)];
      const auto at = [&](int u, int v) {
        return depth.at<float>(std::clamp(v + margin, 0, h - 1), std::clamp(u + margin, 0, w - 1));
      };
      const Eigen::Vector2f n(at(x - 1, y) - at(x + 1, y), at(x, y + 1) - at(x, y - 1));
      out.normal[i] = n / std::max(2.0f, n.norm());
    }
  return out;
}

std::vector<float> binder_width(const std::int32_t* ids, int width, int height, bool wrap, double unit,
                                const Work& work) {
  const int widest = round_up(64 * unit);
  const double smooth = 4 * unit;
  constexpr float kSlack = 1.5f;  // centers are whole pixels, so disks do not quite touch outlines
  // A disk's center may lie a radius outside, and what bounds it another radius farther.
  const int margin = wrap ? 2 * widest + round_up(4 * smooth) : 0, w = width + 2 * margin,
            h = height + 2 * margin;
  cv::Mat binder(h, w, CV_8U), depth, near, out(h, w, CV_32F, cv::Scalar(0)), weight(h, w, CV_32F);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const std::size_t at = pixel_at(wrap_index(x - margin, width), wrap_index(y - margin, height), width);
      binder.at<std::uint8_t>(y, x) = ids[at] > 0 ? 0 : 255;
      weight.at<float>(y, x) = ids[at] > 0 ? 0 : 1;
    }
  cv::distanceTransform(binder, depth, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  // Disks of this radius have centers at least as deep.
  for (int radius = 1; radius <= widest; radius += 1 + radius / 8) {
    work.check();
    const cv::Mat no_center = depth < radius;
    cv::distanceTransform(no_center, near, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    out.setTo(radius, near < radius + kSlack);
  }
  out = out.mul(weight);
  cv::GaussianBlur(out, out, {0, 0}, smooth, smooth, cv::BORDER_REPLICATE);
  cv::GaussianBlur(weight, near, {0, 0}, smooth, smooth, cv::BORDER_REPLICATE);
  std::vector<float> widths(pixels_in(width, height), 0.0f);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (near.at<float>(y + margin, x + margin) > 1e-3f)  // also beside it, for pixels that show both
        widths[pixel_at(x, y, width)] =
            out.at<float>(y + margin, x + margin) / near.at<float>(y + margin, x + margin);
  return widths;
}

std::vector<float> sizes_of_particles(std::span<const std::int32_t> ids, double pixel) {
  std::int32_t largest = 0;
  for (const auto id : ids) largest = std::max(largest, id);
  std::vector<std::int64_t> pixels(largest + 1, 0);
  for (const auto id : ids) ++pixels[id];
  std::vector<float> sizes(pixels.size(), 0.0f);
  for (std::size_t k = 1; k < sizes.size(); ++k)
    sizes[k] = std::sqrt(4 * static_cast<double>(pixels[k]) / M_PI) * pixel;
  return sizes;
}

std::vector<float> outline_depth(const std::int32_t* ids, int width, int height, bool wrap) {
  return nearest_outlines(ids, width, height, wrap).depth;
}

}  // namespace terrazzo::residual

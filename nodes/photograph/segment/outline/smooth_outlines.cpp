#include "nodes/photograph/segment/outline/smooth_outlines.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "nodes/data/indices.h"
#include "nodes/photograph/segment/network/candidates.h"
#include "nodes/photograph/segment/outline/coverage.h"

namespace terrazzo::segment {
namespace {

constexpr int kDeep = 2;     // pixels from the outline at which colors are pure
constexpr int kApart = 3;    // pixels between two of which the texture is measured
constexpr int kBeside = 8;   // pixels around a particle's box in which its binder is
constexpr int kEnough = 20;  // pixels that a mean needs

// Mean color and texture of pixels of one label.
struct Look {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double pixels = 0, squares = 0, pairs = 0;
  Eigen::Vector3d mean() const { return sum / std::max(pixels, 1.0); }
  double variance() const { return squares / (2 * std::max(pairs, 1.0)); }
};

struct Smoothed {
  cv::Rect box;
  cv::Mat distance;  // to the outline in pixels, positive inside; empty: the particle keeps its pixels
};

class Outlines {
 public:
  Outlines(const LabImage& image, const std::vector<std::int32_t>& labels, const Work& work)
      : width_(image.width), height_(image.height), labels_(labels), image_(image) {
    deep_.assign(labels.size(), 1);
    work.quiet().parallel(height_, 16, [&](std::size_t begin, std::size_t end) {
      for (int y = begin; y < static_cast<int>(end); ++y)
        for (int x = 0; x < width_; ++x)
          for (int v = std::max(0, y - kDeep); v <= std::min(height_ - 1, y + kDeep); ++v)
            for (int u = std::max(0, x - kDeep); u <= std::min(width_ - 1, x + kDeep); ++u)
              if (labels_[at(u, v)] != labels_[at(x, y)]) deep_[at(x, y)] = 0;
    });
    binder_ = look(0, {0, 0, width_, height_});
  }

  bool has_binder() const { return binder_.pixels >= kEnough; }

  Smoothed smooth(std::int32_t label, const cv::Rect& tight) const {
    double area = 0;
    for (int y = tight.y; y < tight.br().y; ++y)
      for (int x = tight.x; x < tight.br().x; ++x) area += labels_[at(x, y)] == label;
    const double most = std::min(0.12 * std::sqrt(area), std::max(1.5, 0.03 * std::sqrt(area)));
    const double sigma = most * std::clamp((raggedness(label, tight) - 0.08) / 0.07, 0.0, 1.0);
    if (sigma < 0.3) return {};
    Smoothed out;
    out.box = grown(tight, round_up(3 * sigma) + 2);
    cv::Mat mask(out.box.height, out.box.width, CV_32F);
    for (int y = 0; y < mask.rows; ++y)
      for (int x = 0; x < mask.cols; ++x)
        mask.at<float>(y, x) = labels_[at(out.box.x + x, out.box.y + y)] == label ? 1.0f : 0.0f;
    cv::Mat soft;
    cv::GaussianBlur(mask, soft, {}, sigma, sigma, cv::BORDER_REPLICATE);
    std::vector<float> values(soft.begin<float>(), soft.end<float>());
    const auto last = values.begin() + area - 1;
    std::nth_element(values.begin(), last, values.end(), std::greater<>());
    // Across a straight outline the blurred mask rises by 1/(σ√(2π)) per pixel.
    out.distance = (soft - *last) * (std::sqrt(2 * std::numbers::pi) * sigma);
    return out;
  }

 private:
  // Texture and noise compared with the contrast of particle and binder. Unknown without pure pixels: 0.
  double raggedness(std::int32_t label, const cv::Rect& tight) const {
    const Look own = look(label, tight), near = look(0, grown(tight, kBeside));
    if (own.pixels < kEnough) return 0;
    const Look& binder = near.pixels >= kEnough ? near : binder_;
    const double contrast = (own.mean() - binder.mean()).norm();
    return std::sqrt((own.variance() + binder.variance()) / 2) / std::max(contrast, 1e-6);
  }

  Look look(std::int32_t label, const cv::Rect& box) const {
    Look l;
    const auto counts = [&](int x, int y) { return labels_[at(x, y)] == label && deep_[at(x, y)]; };
    for (int y = box.y; y < box.br().y; ++y)
      for (int x = box.x; x < box.br().x; ++x) {
        if (!counts(x, y)) continue;
        const Vec3f& c = image_.pixels[at(x, y)];
        l.sum += c.cast<double>();
        ++l.pixels;
        const auto pair = [&](int u, int v) {
          if (u < box.br().x && v < box.br().y && counts(u, v)) {
            l.squares += (c - image_.pixels[at(u, v)]).squaredNorm();
            ++l.pairs;
          }
        };
        pair(x + kApart, y);
        pair(x, y + kApart);
      }
    return l;
  }

  cv::Rect grown(const cv::Rect& r, int by) const {
    return cv::Rect(r.x - by, r.y - by, r.width + 2 * by, r.height + 2 * by) &
           cv::Rect(0, 0, width_, height_);
  }
  std::size_t at(int x, int y) const { return pixel_at(x, y, width_); }

  int width_, height_;
  const std::vector<std::int32_t>& labels_;
  const LabImage& image_;
  std::vector<std::uint8_t> deep_;
  Look binder_;
};

}  // namespace

void smooth_outlines(const LabImage& image, std::vector<std::int32_t>& labels, std::vector<float>& coverage,
                     const Work& work) {
  const Outlines outlines(image, labels, work);
  if (!outlines.has_binder()) return;
  const std::int32_t count = *std::max_element(labels.begin(), labels.end());
  const std::vector<cv::Rect> boxes = boxes_of_labels(labels, image.width, count);
  std::vector<Smoothed> smoothed(count);
  work.parallel(count, 8, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      if (!boxes[k].empty()) smoothed[k] = outlines.smooth(static_cast<std::int32_t>(k) + 1, boxes[k]);
  });
  // A pixel belongs to the particle in which it is deepest, and to the binder if it is in none.
  constexpr float kNone = -1e9f;
  std::vector<float> deepest(labels.size(), kNone);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] > 0) {
      if (smoothed[labels[i] - 1].distance.empty())
        deepest[i] = 1e9f;
      else
        labels[i] = 0;
    }
  for (std::size_t k = 0; k < smoothed.size(); ++k) {
    const Smoothed& s = smoothed[k];
    for (int y = 0; y < s.distance.rows; ++y)
      for (int x = 0; x < s.distance.cols; ++x) {
        const std::size_t i = static_cast<std::size_t>(s.box.y + y) * image.width + s.box.x + x;
        const float d = s.distance.at<float>(y, x);
        if (d <= deepest[i]) continue;
        deepest[i] = d;
        if (d >= 0) labels[i] = static_cast<std::int32_t>(k) + 1;
      }
  }
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (deepest[i] <= -1 || deepest[i] >= 1e9f) continue;
    coverage[i] = sided(0.5f + deepest[i], labels[i] > 0);
  }
  // Pixels that a particle has left.
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] == 0) coverage[i] = sided(coverage[i], false);
}

}  // namespace terrazzo::segment

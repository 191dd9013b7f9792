#include "nodes/photograph/segment/network/network_particles.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "nodes/data/indices.h"
#include "nodes/photograph/segment/network/judge.h"

namespace terrazzo::segment {
namespace {

// How much of each pixel the particles cover: labels are whole pixels, so their stairs are smoothed, on the
// right side of one half.
std::vector<float> softened(const std::vector<std::int32_t>& labels, int width, int height) {
  std::vector<float> out(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) out[i] = labels[i] > 0;
  cv::Mat m(height, width, CV_32F, out.data());
  cv::GaussianBlur(m, m, cv::Size(5, 5), 1.0, 1.0, cv::BORDER_REPLICATE);
  for (std::size_t i = 0; i < labels.size(); ++i)
    out[i] = labels[i] > 0 ? std::max(0.5f, out[i]) : std::min(0.499f, out[i]);
  return out;
}

// The pixel of a side of `to` pixels that holds the center of pixel i of the same side in `from` pixels.
std::size_t counterpart(int i, int from, int to) {
  return (2 * static_cast<std::int64_t>(i) + 1) * to / (2 * from);
}

}  // namespace

double confidence_of_score(double score) { return 1 / (1 + std::exp(3.65 - 8.61 * score)); }

NetworkView::NetworkView(const Image& image, int section, double reduction, const Network& network,
                         const Work& work)
    : width_(image.width), height_(image.height), reduction_(reduction) {
  picture_ = encoded_section(image, section);
  if (reduction < 1)
    cv::resize(picture_, picture_,
               cv::Size(std::max(1, round_nearest(width_ * reduction)),
                        std::max(1, round_nearest(height_ * reduction))),
               0, 0, cv::INTER_AREA);
  // Below these widths the network would only see the mirrored margin, or too little around large particles.
  constexpr double kLeastHalf = 96, kLeastQuarter = 256;
  const int side = std::min(picture_.cols, picture_.rows);
  std::vector<double> useful{1};
  if (side * 0.5 >= kLeastHalf) useful.push_back(0.5);
  if (side * 0.25 >= kLeastQuarter) useful.push_back(0.25);
  std::vector<NetworkMaps> maps = network(picture_, useful, work);
  std::vector<std::optional<ScaleView>> views(maps.size());
  work.quiet().parallel(maps.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) views[k].emplace(std::move(maps[k]), useful[k], work.quiet());
  });
  for (auto& view : views) scales_.push_back(std::move(*view));
  near_border_ = scales_.front().near_border().clone();
  for (const ScaleView& view : scales_) near_border_ = cv::max(near_border_, view.near_border());
}

NetworkView::Found NetworkView::choose(const std::vector<Instance>& instances, const NetworkOptions& options,
                                       const Work& work) const {
  Accepted accepted = accept_instances(instances, width_, height_, options.min_area, options.min_score,
                                       confidence_of_score, work);
  Found found;
  found.scores = std::move(accepted.scores);
  found.from = std::move(accepted.from);
  Particles2D& out = found.particles;
  out.min_area = options.min_area;
  out.labels = std::move(accepted.labels);
  out.coverage = softened(out.labels, width_, height_);
  return found;
}

std::size_t NetworkView::reduced_index(int x, int y) const {
  return counterpart(y, height_, picture_.rows) * picture_.cols + counterpart(x, width_, picture_.cols);
}

std::vector<float> NetworkView::not_material() const {
  const NetworkMaps& own = scales_.front().maps();
  if (reduction_ >= 1) return own.not_material;
  std::vector<float> out(pixels_in(width_, height_));
  cv::Mat enlarged(height_, width_, CV_32F, out.data());
  cv::resize(scales_.front().map(own.not_material), enlarged, enlarged.size(), 0, 0, cv::INTER_LINEAR);
  return out;
}

double NetworkView::largest_inside(const std::vector<std::int32_t>& pixels) const {
  double largest = 0;
  for (const ScaleView& view : scales_) {
    double sum = 0;
    for (const auto i : pixels) sum += view.maps().inside[reduced_index(i % width_, i / width_)];
    if (!pixels.empty()) largest = std::max(largest, sum / pixels.size());
  }
  return largest;
}

UndecidedPixels NetworkView::undecided(const std::vector<std::int32_t>& labels) const {
  constexpr float kLikely = 0.5f;
  UndecidedPixels out(labels.size(), 0);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const std::size_t i = pixel_at(x, y, width_), seen = reduced_index(x, y);
      if (labels[i] == 0)
        out[i] = std::any_of(scales_.begin(), scales_.end(),
                             [&](const ScaleView& view) { return view.maps().inside[seen] > kLikely; });
    }
  return out;
}

std::vector<std::int32_t> NetworkView::reduced(const std::vector<std::int32_t>& labels) const {
  std::vector<std::int32_t> out(picture_.total());
  for (int y = 0; y < picture_.rows; ++y)
    for (int x = 0; x < picture_.cols; ++x)
      out[pixel_at(x, y, picture_.cols)] =
          labels[counterpart(y, picture_.rows, height_) * width_ + counterpart(x, picture_.cols, width_)];
  return out;
}

std::vector<double> NetworkView::scores(const std::vector<std::int32_t>& of_section, int count,
                                        const Work& work) const {
  const NetworkMaps& own = scales_.front().maps();
  const std::vector<std::int32_t> labels = reduced(of_section);
  const std::vector<cv::Rect> boxes = boxes_of_labels(labels, own.width, count);
  std::vector<double> best(count, 0);
  work.parallel(count, 16, [&](std::size_t begin, std::size_t end) {
    for (const ScaleView& view : scales_) {
      std::vector<Evidence> evidence;
      std::vector<std::size_t> whose;
      for (std::size_t k = begin; k < end; ++k) {
        if (boxes[k].empty()) continue;
        const Cutout region = cut_out_label(labels, own.width, own.height, k + 1, boxes[k]);
        evidence.push_back(evidence_of(region, view, near_border_));
        whose.push_back(k);
      }
      const std::vector<float> scores = built_in_judge()(evidence);
      for (std::size_t i = 0; i < whose.size(); ++i)
        best[whose[i]] = std::max<double>(best[whose[i]], scores[i]);
    }
  });
  return best;
}

}  // namespace terrazzo::segment

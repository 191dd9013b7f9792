#include "nodes/photograph/segment/network/candidates.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "nodes/photograph/segment/network/basins.h"

namespace terrazzo::segment {
namespace {

constexpr int kMarginOfRegion = 6;  // as far as evidence looks around

std::vector<float> levels() {
  std::vector<float> out{0.04f, 0.07f};
  for (int k = 2; k <= 18; ++k) out.push_back(0.05f * k);
  return out;
}

cv::Rect with_margin(const cv::Rect& box, int width, int height) {
  return cv::Rect(box.x - kMarginOfRegion, box.y - kMarginOfRegion, box.width + 2 * kMarginOfRegion,
                  box.height + 2 * kMarginOfRegion) &
         cv::Rect(0, 0, width, height);
}

// At low levels, most of a section is one ragged component. It is no particle and takes long to look at.
bool sprawls(const cv::Mat& stats, double section) {
  constexpr double kLarge = 1e4, kShareOfSection = 0.7, kShareOfBox = 0.2;
  const double area = stats.at<int>(cv::CC_STAT_AREA),
               box = 1.0 * stats.at<int>(cv::CC_STAT_WIDTH) * stats.at<int>(cv::CC_STAT_HEIGHT);
  return area > kLarge && (area > kShareOfSection * section || area < kShareOfBox * box);
}

}  // namespace

void fill_holes_of(cv::Mat& mask) {
  cv::Mat around;
  cv::copyMakeBorder(1 - mask, around, 1, 1, 1, 1, cv::BORDER_CONSTANT, 1);
  cv::floodFill(around, cv::Point(0, 0), 0);
  mask |= around(cv::Rect(1, 1, mask.cols, mask.rows));
}

std::vector<std::int32_t> Cutout::pixels(int width) const {
  std::vector<std::int32_t> out;
  for (int y = 0; y < mask.rows; ++y) {
    const auto* row = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < mask.cols; ++x)
      if (row[x]) out.push_back((box.y + y) * width + box.x + x);
  }
  return out;
}

int Cutout::area() const { return mask.empty() ? 0 : cv::countNonZero(mask); }

double overlap_of(const Cutout& a, const Cutout& b) {
  const cv::Rect both = a.box & b.box;
  if (both.empty()) return 0;
  const double shared = cv::countNonZero(a.mask(both - a.box.tl()) & b.mask(both - b.box.tl()));
  return shared > 0 ? shared / (a.area() + b.area() - shared) : 0;
}

std::vector<cv::Rect> boxes_of_labels(const std::vector<std::int32_t>& labels, int width, int count) {
  std::vector<cv::Rect> boxes(count);
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (labels[i] > 0)
      boxes[labels[i] - 1] |= cv::Rect(static_cast<int>(i % width), static_cast<int>(i / width), 1, 1);
  return boxes;
}

Cutout cut_out_label(const std::vector<std::int32_t>& labels, int width, int height, std::int32_t label,
                     const cv::Rect& box) {
  Cutout r;
  r.box = with_margin(box, width, height);
  const cv::Mat all(height, width, CV_32S, const_cast<std::int32_t*>(labels.data()));
  r.mask = (all(r.box) == label) / 255;
  return r;
}

ScaleView::ScaleView(NetworkMaps maps, double scale, const Work& work)
    : maps_(std::move(maps)), scale_(scale), basins_(find_basins(maps_, work)) {
  cv::dilate(map(maps_.border), near_border_, cv::Mat::ones(3, 3, CV_8U));
  const cv::Mat inside = map(maps_.inside);
  within_ = inside - inside.mul(map(maps_.border));
}

cv::Mat ScaleView::map(const std::vector<float>& values) const {
  return {maps_.height, maps_.width, CV_32F, const_cast<float*>(values.data())};
}

std::vector<Candidate> ScaleView::candidates(double min_area, const Work& work) const {
  constexpr double kSame = 0.8;
  std::vector<Candidate> out;
  std::int32_t basin = 0;
  for (const cv::Rect& box :
       boxes_of_labels(basins_, maps_.width, *std::max_element(basins_.begin(), basins_.end())))
    if (++basin; !box.empty()) out.push_back({box, basin, {}, 0});
  cv::Mat labels, stats, centers, before;
  std::vector<int> areas, areas_before;
  for (const float level : levels()) {
    work.check();
    const int count = cv::connectedComponentsWithStats(within_ > level, labels, stats, centers, 4, CV_32S);
    areas.assign(count, 0);
    for (int k = 1; k < count; ++k) {
      areas[k] = stats.at<int>(k, cv::CC_STAT_AREA);
      if (areas[k] < 0.5 * min_area || sprawls(stats.row(k), within_.total())) continue;
      Candidate c;
      c.box = {stats.at<int>(k, cv::CC_STAT_LEFT), stats.at<int>(k, cv::CC_STAT_TOP),
               stats.at<int>(k, cv::CC_STAT_WIDTH), stats.at<int>(k, cv::CC_STAT_HEIGHT)};
      c.level = level;
      const auto* top = labels.ptr<int>(c.box.y);
      c.seed = {c.box.x, c.box.y};
      while (top[c.seed.x] != k) ++c.seed.x;
      if (!before.empty() && areas[k] > kSame * areas_before[before.at<int>(c.seed)]) continue;
      out.push_back(c);
    }
    std::swap(labels, before);
    std::swap(areas, areas_before);
  }
  return out;
}

Cutout ScaleView::cut_out(const Candidate& c) const {
  if (c.basin > 0) return cut_out_label(basins_, maps_.width, maps_.height, c.basin, c.box);
  Cutout r;
  r.box = with_margin(c.box, maps_.width, maps_.height);
  cv::Mat parts = within_(r.box) > c.level;
  cv::floodFill(parts, c.seed - r.box.tl(), 1, nullptr, 0, 0, 4);
  r.mask = (parts == 1) / 255;
  static const cv::Mat cross = cv::getStructuringElement(cv::MORPH_CROSS, cv::Size(3, 3));
  cv::dilate(r.mask, r.mask, cross, cv::Point(-1, -1), scale_ < 0.6 ? 2 : 1);
  cv::medianBlur(r.mask, r.mask, 3);
  fill_holes_of(r.mask);
  return r;
}

}  // namespace terrazzo::segment

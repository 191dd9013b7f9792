#include "nodes/photograph/marks/frame.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "nodes/photograph/marks/levels.h"

namespace terrazzo::segment {
namespace {

constexpr int kExact = 4;  // levels

// The picture without strips that run along one of its edges.
cv::Rect without_strips(const cv::Rect& whole, const std::vector<cv::Rect>& strips) {
  int left = 0, top = 0, right = whole.width, bottom = whole.height;
  for (const cv::Rect& s : strips) {
    if (s.width == whole.width && s.y == 0) top = std::max(top, s.br().y);
    if (s.width == whole.width && s.br().y == whole.height) bottom = std::min(bottom, s.y);
    if (s.height == whole.height && s.x == 0) left = std::max(left, s.br().x);
    if (s.height == whole.height && s.br().x == whole.width) right = std::min(right, s.x);
  }
  return {left, top, std::max(0, right - left), std::max(0, bottom - top)};
}

// Line `k` of a rectangle from its upper, lower, left or right edge.
cv::Rect line_of(const cv::Rect& r, int side, int k) {
  switch (side) {
    case 0:
      return {r.x, r.y + k, r.width, 1};
    case 1:
      return {r.x, r.br().y - 1 - k, r.width, 1};
    case 2:
      return {r.x + k, r.y, 1, r.height};
    default:
      return {r.br().x - 1 - k, r.y, 1, r.height};
  }
}

double share(const cv::Mat& mask) {
  return cv::countNonZero(mask) / static_cast<double>(std::max<std::size_t>(1, mask.total()));
}

// How many lines of a side belong to the frame; 0 where its edge is not a straight line.
int lines_of_side(const cv::Mat& has_color, const cv::Rect& picture, int side) {
  constexpr double kFlat = 0.99, kOther = 0.5;
  const int most = (side < 2 ? picture.height : picture.width) / 3;
  int n = 0;
  while (n < most && share(has_color(line_of(picture, side, n))) >= kFlat) ++n;
  constexpr int kBlurred = 2;
  // Within the other sides of the frame, so that these do not count as its color.
  cv::Rect behind = line_of(picture, side, std::min(n + kBlurred, most));
  (side < 2 ? behind.x : behind.y) += most / 2;
  (side < 2 ? behind.width : behind.height) -= most;
  return n < 3 || n == most || share(has_color(behind)) > kOther ? 0 : n;
}

}  // namespace

std::vector<cv::Rect> find_frame(const cv::Mat& levels, const std::vector<cv::Rect>& strips) {
  constexpr int kSmallest = 32;
  constexpr double kRare = 0.05;
  const cv::Rect picture = without_strips(cv::Rect({0, 0}, levels.size()), strips);
  if (std::min(picture.width, picture.height) < kSmallest) return {};
  std::array<int, 4> best{};
  for (int from = 0; from < 4; ++from) {
    const cv::Mat has_color = distance_from(levels, commonest(levels(line_of(picture, from, 0)))) <= kExact;
    std::array<int, 4> lines;
    for (int side = 0; side < 4; ++side) lines[side] = lines_of_side(has_color, picture, side);
    const cv::Rect inside(picture.x + lines[2], picture.y + lines[0], picture.width - lines[2] - lines[3],
                          picture.height - lines[0] - lines[1]);
    if (std::count(lines.begin(), lines.end(), 0) <= 2 && share(has_color(inside)) <= kRare &&
        std::count(lines.begin(), lines.end(), 0) < std::count(best.begin(), best.end(), 0))
      best = lines;
  }
  const auto [top, bottom, left, right] = best;
  std::vector<cv::Rect> found;
  // With the line that mixes the frame with the picture.
  const int w = levels.cols, h = levels.rows;
  if (top) found.emplace_back(0, picture.y, w, top + 1);
  if (bottom) found.emplace_back(0, picture.br().y - bottom - 1, w, bottom + 1);
  if (left) found.emplace_back(picture.x, 0, left + 1, h);
  if (right) found.emplace_back(picture.br().x - right - 1, 0, right + 1, h);
  return found;
}

}  // namespace terrazzo::segment

#include "nodes/photograph/marks/captions.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "nodes/photograph/marks/frame.h"
#include "nodes/photograph/marks/levels.h"
#include "nodes/photograph/marks/text_lines.h"
#include "nodes/photograph/marks/text_panel.h"

namespace terrazzo::segment {
namespace {

constexpr double kHighestStrip = 0.35;  // of the picture
constexpr int kSame = 10;               // levels: compression changes a flat color by less
constexpr int kContrast = 45;           // levels, between text and what is under it
constexpr int kThickestLine = 4;        // pixels

// The share of pixels of each row that are 255.
std::vector<double> shares_of_rows(const cv::Mat& mask) {
  std::vector<double> out(mask.rows);
  for (int y = 0; y < mask.rows; ++y) out[y] = static_cast<double>(cv::countNonZero(mask.row(y))) / mask.cols;
  return out;
}

// The share of a row that has the row's commonest color.
double share_of_line(const cv::Mat& row) {
  return static_cast<double>(cv::countNonZero(distance_from(row, commonest(row)) <= kSame)) / row.cols;
}

bool has_text(const cv::Mat& strip, const cv::Vec3b& background) {
  const cv::Mat ink = distance_from(strip, background) > kContrast;
  const int highest = strip.rows * 9 / 10;
  if (!find_text(ink, highest).empty()) return true;
  // The strip was turned to the lower edge, and text at the side may be turned itself.
  const auto turns = {cv::ROTATE_180, cv::ROTATE_90_CLOCKWISE, cv::ROTATE_90_COUNTERCLOCKWISE};
  return std::any_of(turns.begin(), turns.end(), [&](int turn) {
    cv::Mat turned;
    cv::rotate(ink, turned, turn);
    return !find_text(turned, highest).empty();
  });
}

// The color of cells within a strip: the commonest one that is not the strip's.
cv::Vec3b second_color(const cv::Mat& strip, const cv::Vec3b& background) {
  const cv::Mat other = distance_from(strip, background) > kSame;
  cv::Mat rest(1, std::max(1, cv::countNonZero(other)), CV_8UC3,
               cv::Scalar(background[0], background[1], background[2]));
  int n = 0;
  for (int y = 0; y < strip.rows; ++y)
    for (int x = 0; x < strip.cols; ++x)
      if (other.at<std::uint8_t>(y, x)) rest.at<cv::Vec3b>(0, n++) = strip.at<cv::Vec3b>(y, x);
  return commonest(rest);
}

// The first row of the flat strip, without lines around it; the picture's height: there is none. `away`: how
// far each pixel is from the strip's colors.
int first_flat_row(const cv::Mat& away, const cv::Mat& levels) {
  const int height = levels.rows;
  const cv::Mat flat = away <= kSame;
  const cv::Mat exact = away <= 2;
  const std::vector<double> share = shares_of_rows(flat), exactly = shares_of_rows(exact);
  int best = height, strange = 0;
  double flat_sum = share[height - 1], exact_sum = exactly[height - 1];
  for (int y = height - 2; y >= std::max(4, height - static_cast<int>(kHighestStrip * height)); --y) {
    flat_sum += share[y];
    exact_sum += exactly[y];
    strange = share[y] >= 0.2 || share_of_line(levels.row(y)) >= 0.8 ? 0 : strange + 1;
    if (strange > kThickestLine) break;
    cv::Mat steps;
    cv::bitwise_and(flat.row(y), flat.row(y + 1), steps);
    steps.setTo(0, flat.row(y - 2) | flat.row(y - 3));
    const double n = height - y;
    if (cv::countNonZero(steps) >= 0.3 * levels.cols && flat_sum >= 0.55 * n && exact_sum >= 0.6 * flat_sum)
      best = y;
  }
  return best;
}

// Adds the line around the strip and the row that mixes it with the picture.
int with_its_line(const cv::Mat& levels, int first) {
  const cv::Vec3b color = commonest(levels.row(first - 1));
  int y = first;
  const auto of_line = [&](int row) {
    return cv::countNonZero(distance_from(levels.row(row), color) <= 2 * kSame) >= 0.9 * levels.cols;
  };
  while (y > 2 && first - y <= kThickestLine && of_line(y - 1)) --y;
  if (first - y > kThickestLine) y = first;  // that is the picture's own color
  const auto brightness = [&](int row) {
    const cv::Scalar m = cv::mean(levels.row(row));
    return m[0] + m[1] + m[2];
  };
  const double outside = brightness(y - 2), between = brightness(y - 1) - outside,
               inside = brightness(y) - outside;
  return between * inside > 0 && std::abs(between) > 0.15 * std::abs(inside) ? y - 1 : y;
}

}  // namespace

int strip_height(const cv::Mat& levels) {
  constexpr int kLowest = 10;
  const int height = levels.rows;
  if (height < 4 * kLowest || levels.cols < 4 * kLowest) return 0;
  const cv::Vec3b color = commonest(levels.rowRange(height - std::max(8, height / 50), height));
  // Some strips are tables whose cells have a second color.
  const cv::Vec3b cells = second_color(levels.rowRange(height - std::max(8, height / 20), height), color);
  const cv::Mat away = distance_from(levels, color);
  for (const cv::Mat& of_strip : {away, cv::Mat(cv::min(away, distance_from(levels, cells)))}) {
    const int first = first_flat_row(of_strip, levels);
    if (height - first < kLowest) continue;
    const cv::Mat strip = levels.rowRange(first, height);
    if (has_text(strip, color) || has_text(strip, second_color(strip, color)))
      return height - with_its_line(levels, first);
  }
  return 0;
}

std::vector<cv::Rect> find_captions(const cv::Mat& levels) {
  const int w = levels.cols, h = levels.rows;
  std::vector<cv::Rect> found;
  if (const int n = strip_height(levels)) found.emplace_back(0, h - n, w, n);
  cv::Mat turned;
  cv::rotate(levels, turned, cv::ROTATE_180);
  if (const int n = strip_height(turned)) found.emplace_back(0, 0, w, n);
  cv::rotate(levels, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
  if (const int n = strip_height(turned)) found.emplace_back(0, 0, n, h);
  cv::rotate(levels, turned, cv::ROTATE_90_CLOCKWISE);
  if (const int n = strip_height(turned)) found.emplace_back(w - n, 0, n, h);
  const std::vector<cv::Rect> frame = find_frame(levels, found);
  found.insert(found.end(), frame.begin(), frame.end());
  const std::vector<cv::Rect> panels = find_text_panels(levels, found);
  found.insert(found.end(), panels.begin(), panels.end());
  return found;
}

}  // namespace terrazzo::segment

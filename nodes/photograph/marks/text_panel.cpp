#include "nodes/photograph/marks/text_panel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "nodes/photograph/marks/levels.h"
#include "nodes/photograph/marks/text_lines.h"

namespace terrazzo::segment {
namespace {

// How strongly each pixel has the color of an ink: white, black, or a color of full saturation, which no
// material has.
std::array<cv::Mat, 3> strengths_of(const cv::Mat& levels) {
  std::array<cv::Mat, 3> out;
  for (auto& m : out) m.create(levels.size(), CV_8U);
  for (int y = 0; y < levels.rows; ++y)
    for (int x = 0; x < levels.cols; ++x) {
      const auto& c = levels.at<cv::Vec3b>(y, x);
      const auto [low, high] = std::minmax({c[0], c[1], c[2]});
      out[0].at<std::uint8_t>(y, x) = low;
      out[1].at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(255 - high);
      out[2].at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(high - low);
    }
  return out;
}

// Ink: components of pixels that are nearer to full strength than to what is around them, so that thin
// strokes stay whole, with a part of at least the strength `seen`.
cv::Mat ink_of(const cv::Mat& strength, int full, int seen) {
  constexpr int kAround = 31;  // pixels
  cv::Mat around, labels;
  cv::blur(strength, around, {kAround, kAround}, {-1, -1}, cv::BORDER_REPLICATE);
  cv::Mat ink(strength.size(), CV_8U);
  for (int y = 0; y < ink.rows; ++y)
    for (int x = 0; x < ink.cols; ++x)
      ink.at<std::uint8_t>(y, x) =
          2 * strength.at<std::uint8_t>(y, x) > full + around.at<std::uint8_t>(y, x) ? 255 : 0;
  std::vector<std::uint8_t> kept(cv::connectedComponents(ink, labels, 8), 0);
  for (int y = 0; y < ink.rows; ++y)
    for (int x = 0; x < ink.cols; ++x)
      if (strength.at<std::uint8_t>(y, x) >= seen) kept[labels.at<int>(y, x)] = 255;
  kept[0] = 0;
  for (int y = 0; y < ink.rows; ++y)
    for (int x = 0; x < ink.cols; ++x) ink.at<std::uint8_t>(y, x) = kept[labels.at<int>(y, x)];
  return ink;
}

cv::Rect grown(const cv::Rect& box, int by, const cv::Size& within) {
  return cv::Rect(box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by) & cv::Rect({0, 0}, within);
}

bool touches(const cv::Rect& box, const std::vector<cv::Rect>& some) {
  return std::any_of(some.begin(), some.end(), [&](const cv::Rect& r) { return (r & box).area() > 0; });
}

// Whether ink stands out from what is around it.
bool stands_out(const cv::Mat& levels, const cv::Mat& ink, const cv::Rect& box) {
  constexpr double kContrast = 45;  // levels
  const cv::Rect around = grown(box, 3, ink.size());
  cv::Mat near;
  cv::dilate(ink(around), near, cv::Mat(), {-1, -1}, 1);
  const cv::Mat outside = near == 0;
  if (cv::countNonZero(outside) == 0) return false;
  const cv::Scalar d = cv::mean(levels(around), ink(around)) - cv::mean(levels(around), outside);
  return std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}) >= kContrast;
}

// Whether little of the ink around the text is other than text.
bool stands_alone(const cv::Mat& ink, const cv::Rect& box, const std::vector<cv::Rect>& text) {
  constexpr double kMost = 0.03;
  const int margin = std::max(2, box.height / 4);
  const cv::Rect around = grown(box, std::max(box.height, 10), ink.size());
  cv::Mat rest(around.size(), CV_8U, cv::Scalar(255));
  for (const cv::Rect& t : text) {
    const cv::Rect own = grown(t, margin, ink.size()) & around;
    if (own.area() > 0) rest(own - around.tl()).setTo(0);
  }
  const int all = cv::countNonZero(rest);
  cv::bitwise_and(rest, ink(around), rest);
  return cv::countNonZero(rest) <= kMost * all;
}

// The flat rectangle that the text was written on.
std::optional<cv::Rect> flat_panel(const cv::Mat& levels, const cv::Mat& ink, const cv::Rect& box) {
  const cv::Rect text = grown(box, 3, levels.size());
  constexpr double kFlat = 0.6, kFull = 0.9,
                   kLargest = 0.35;  // of the text's box; of the panel; of the picture
  cv::Mat near;
  cv::dilate(ink(text), near, cv::Mat(), {-1, -1}, 2);
  cv::Mat rest(1, std::max(1, text.area() - cv::countNonZero(near)), CV_8UC3, cv::Scalar(0, 0, 0));
  int n = 0;
  for (int y = 0; y < text.height; ++y)
    for (int x = 0; x < text.width; ++x)
      if (!near.at<std::uint8_t>(y, x))
        rest.at<cv::Vec3b>(0, n++) = levels.at<cv::Vec3b>(text.y + y, text.x + x);
  const cv::Vec3b color = commonest(rest);
  constexpr int kExact = 3, kSame = 10;
  if (cv::countNonZero(distance_from(rest, color) <= kExact) < kFlat * n || n == 0) return {};
  cv::Mat flat = distance_from(levels, color) <= kSame;
  flat(text).setTo(255);
  cv::Mat labels, stats, centers;
  cv::connectedComponentsWithStats(flat, labels, stats, centers, 4);
  const int k = labels.at<int>(text.y + text.height / 2, text.x + text.width / 2);
  const cv::Rect panel(stats.at<int>(k, cv::CC_STAT_LEFT), stats.at<int>(k, cv::CC_STAT_TOP),
                       stats.at<int>(k, cv::CC_STAT_WIDTH), stats.at<int>(k, cv::CC_STAT_HEIGHT));
  cv::Mat all = labels(panel) == k;
  all |= ink(panel);
  if (panel.area() > kLargest * static_cast<double>(levels.total()) ||
      cv::countNonZero(all) < kFull * panel.area())
    return {};
  return panel;
}

// How steadily the picture becomes lighter or darker from the row above `y` to the row at `y`, between two
// columns: the share of the columns that agree, signed. Columns that are black, or white, on both sides say
// nothing; none if all are.
std::optional<double> step_at(const cv::Mat& gray, int y, int left, int right) {
  constexpr int kVisible = 6, kBlack = 20, kWhite = 235;  // levels
  int up = 0, down = 0, all = 0;
  for (int x = left; x < right; ++x) {
    const int a = gray.at<std::uint8_t>(y - 1, x), b = gray.at<std::uint8_t>(y, x);
    if (std::max(a, b) < kBlack || std::min(a, b) > kWhite) continue;
    up += b - a >= kVisible;
    down += a - b >= kVisible;
    ++all;
  }
  if (all == 0) return {};
  return static_cast<double>(up > down ? up : -down) / all;
}

// The edge of a panel that the picture shines through: the nearest row with a step along the whole text.
std::optional<int> panel_edge(const cv::Mat& gray, const cv::Rect& text, int direction) {
  constexpr double kAgree = 0.85;
  const int reach = 4 * text.height;
  const int start = direction < 0 ? text.y : text.br().y;
  for (int k = 0; k <= reach; ++k) {
    const int y = start + direction * k;
    if (y <= 1 || y >= gray.rows - 1) return direction < 0 ? 0 : gray.rows;
    if (std::abs(step_at(gray, y, text.x, text.br().x).value_or(0)) >= kAgree) return y;
  }
  return {};
}

// How far the step of row `y` continues from column `x`.
int end_of_step(const cv::Mat& gray, int y, int x, int direction, bool up) {
  constexpr int kWindow = 12;
  constexpr double kAgree = 0.7;
  while (x > 0 && x < gray.cols) {
    const int next = std::clamp(x + direction * kWindow, 0, gray.cols);
    const auto step = step_at(gray, y, std::min(x, next), std::max(x, next));
    if (step && ((*step > 0) != up || std::abs(*step) < kAgree)) break;
    x = next;
  }
  return x;
}

std::optional<cv::Rect> clear_panel(const cv::Mat& gray, const cv::Rect& text) {
  const auto top = panel_edge(gray, text, -1), bottom = panel_edge(gray, text, 1);
  if (!top || !bottom || (*top == 0 && *bottom == gray.rows)) return {};
  const int edge = *top > 0 ? *top : *bottom;
  const bool up = step_at(gray, edge, text.x, text.br().x).value_or(0) > 0;
  const int left = end_of_step(gray, edge, text.x, -1, up),
            right = end_of_step(gray, edge, text.br().x, 1, up);
  return cv::Rect(left, *top, right - left, *bottom - *top);
}

// The boxes around those that overlap.
std::vector<cv::Rect> joined(std::vector<cv::Rect> boxes) {
  for (std::size_t k = 0; k < boxes.size(); ++k)
    for (std::size_t j = 0; j < boxes.size(); ++j)
      if (j != k && (boxes[j] & boxes[k]).area() > 0) {
        boxes[std::min(j, k)] |= boxes[std::max(j, k)];
        boxes.erase(boxes.begin() + (std::max(j, k)));
        k = j = 0;
      }
  return boxes;
}

// Whether a bar is a rectangle of one exact color, as only a drawn one is.
bool is_drawn(const cv::Mat& levels, const cv::Rect& bar) {
  constexpr int kExact = 3;  // levels
  constexpr double kFull = 0.97, kOutside = 0.1;
  const cv::Rect around = grown(bar, 2, levels.size());
  const cv::Mat same = distance_from(levels(around), commonest(levels(bar))) <= kExact;
  const int all = cv::countNonZero(same), inside = cv::countNonZero(same(bar - around.tl()));
  return bar.width >= 5 * bar.height && inside >= kFull * bar.area() &&
         all - inside <= kOutside * (around.area() - bar.area());
}

// Scale bars without text: the flat panels around them, or the bar itself if only one is drawn into the
// picture.
std::vector<cv::Rect> lone_bars(const cv::Mat& levels, const cv::Mat& ink,
                                const std::vector<cv::Rect>& known) {
  std::vector<cv::Rect> out, drawn;
  for (const cv::Rect& bar : find_bars(ink)) {
    const cv::Rect around = grown(bar, std::max(4, bar.height), levels.size());
    if (touches(around, known) || touches(around, out) || !stands_out(levels, ink, bar)) continue;
    const auto panel = flat_panel(levels, ink, around);
    if (panel && (*panel & around) == around)
      out.push_back(*panel);
    else if (is_drawn(levels, bar))
      drawn.push_back(grown(bar, 2, levels.size()));
  }
  if (out.empty() && drawn.size() == 1) out = drawn;
  return out;
}

}  // namespace

std::vector<cv::Rect> find_text_panels(const cv::Mat& levels, const std::vector<cv::Rect>& known) {
  cv::Mat gray;
  cv::cvtColor(levels, gray, cv::COLOR_RGB2GRAY);
  const std::array<cv::Mat, 3> strengths = strengths_of(levels);
  // JPEG keeps light better than color.
  constexpr std::array<int, 3> kFull = {255, 255, 200}, kSeen = {225, 225, 110};
  std::vector<cv::Rect> found;
  for (std::size_t k = 0; k < strengths.size(); ++k) {
    const cv::Mat ink = ink_of(strengths[k], kFull[k], kSeen[k]);
    std::vector<cv::Rect> text = find_text(ink, levels.rows / 8);
    std::erase_if(text,
                  [&](const cv::Rect& box) { return touches(box, known) || !stands_out(levels, ink, box); });
    for (const cv::Rect& box : text) {
      auto panel = flat_panel(levels, ink, box);
      if (!panel && !stands_alone(ink, box, text)) continue;
      if (!panel) panel = clear_panel(gray, box);
      const cv::Rect around = grown(box, std::max(2, box.height / 3), levels.size());
      found.push_back(panel ? *panel | around : around);
    }
    const std::vector<cv::Rect> bars = lone_bars(levels, ink, known);
    found.insert(found.end(), bars.begin(), bars.end());
  }
  return joined(std::move(found));
}

}  // namespace terrazzo::segment

#include "nodes/photograph/marks/scales.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "nodes/data/indices.h"
#include "nodes/photograph/marks/combs.h"
#include "nodes/photograph/marks/levels.h"

namespace terrazzo::segment {
namespace {

constexpr double kDegree = CV_PI / 180;

// The lighter and the darker color of the marks at each column of a comb, since light changes along a ruler.
struct MarkColors {
  std::vector<cv::Vec3b> light, dark;
};

MarkColors colors_of(const cv::Mat& band, double step) {
  const int reach = round_up(1.2 * step);
  const auto luma = [](const cv::Vec3b& c) { return 299 * c[0] + 587 * c[1] + 114 * c[2]; };
  MarkColors out;
  std::vector<cv::Vec3b> near;
  for (int x = 0; x < band.cols; ++x) {
    near.clear();
    for (int y = 0; y < band.rows; y += std::max(1, band.rows / 5))
      for (int u = std::max(0, x - reach); u < std::min(band.cols, x + reach + 1); ++u)
        near.push_back(band.at<cv::Vec3b>(y, u));
    std::sort(near.begin(), near.end(),
              [&](const cv::Vec3b& a, const cv::Vec3b& b) { return luma(a) < luma(b); });
    out.light.push_back(near[near.size() * 7 / 8]);
    out.dark.push_back(near[near.size() / 8]);
  }
  return out;
}

// The part of a turned picture around a comb that has the colors of its marks.
class Body {
 public:
  Body(const cv::Mat& levels, const TurnedFrame& frame, const Comb& comb)
      : step_(comb.step),
        turned_(frame.turned(levels)),
        inside_(frame.turned(cv::Mat(levels.size(), CV_8U, cv::Scalar(255)))) {
    comb_ = box_ = cv::Rect(comb.left, comb.top, comb.right - comb.left, comb.bottom - comb.top) &
                   cv::Rect({0, 0}, turned_.size());
    const MarkColors colors = colors_of(turned_(box_), step_);
    own_ = cv::Mat(turned_.size(), CV_8U, cv::Scalar(0));
    for (const auto* some : {&colors.light, &colors.dark})
      own([&](int x) { return (*some)[std::clamp(x - comb_.x, 0, comb_.width - 1)]; });
  }

  // The rectangle of the object, or none if it is not one.
  std::optional<cv::Rect> grow() {
    grow_rows();
    // A card may have another color than its marks.
    cv::Mat coarse = turned_(box_).clone();
    for (int y = 0; y < coarse.rows; ++y)
      for (int x = 0; x < coarse.cols; ++x)
        for (int k = 0; k < 3; ++k)
          coarse.at<cv::Vec3b>(y, x)[k] = (coarse.at<cv::Vec3b>(y, x)[k] & 0xF0) + 8;
    const cv::Vec3b paper = commonest(coarse);
    own([&](int) { return paper; }, 0.1);
    grow_columns();
    grow_rows();
    grow_columns();
    constexpr double kLargest = 0.4;
    if (box_.area() > kLargest * cv::countNonZero(inside_) || 2 * box_.width < 3 * box_.height) return {};
    if (!ends(box_.y - kMargin - kRim, box_.y - kMargin) ||
        !ends(box_.br().y + kMargin, box_.br().y + kMargin + kRim))
      return {};
    return box_;
  }

  // How much of the rectangle has the object's colors, less how much has not.
  double fit() const { return 2.0 * cv::countNonZero(own_(box_)) - cv::countNonZero(inside_(box_)); }

 private:
  // Adds the pixels of a color, which may differ from column to column, if they add this share of the
  // rectangle.
  template <class Color>
  void own(const Color& color, double least = 0) {
    cv::Mat more = own_.clone();
    for (int x = 0; x < turned_.cols; ++x) {
      const cv::Vec3b c = color(x);
      for (int y = 0; y < turned_.rows; ++y)
        if (inside_.at<std::uint8_t>(y, x) && near(turned_.at<cv::Vec3b>(y, x), c))
          more.at<std::uint8_t>(y, x) = 255;
    }
    if (cv::countNonZero(more(box_)) - cv::countNonZero(own_(box_)) >= least * box_.area()) own_ = more;
  }

  static bool near(const cv::Vec3b& a, const cv::Vec3b& b) {
    constexpr int kSame = 18;  // levels
    return std::abs(a[0] - b[0]) <= kSame && std::abs(a[1] - b[1]) <= kSame && std::abs(a[2] - b[2]) <= kSame;
  }

  // The share of pixels of the picture in this window that have the colors; none if few are in the picture.
  std::optional<double> share(const cv::Rect& window) const {
    const cv::Rect r = window & cv::Rect({0, 0}, own_.size());
    if (r.empty()) return {};
    const int in = cv::countNonZero(inside_(r));
    if (4 * in < window.area()) return {};
    return static_cast<double>(cv::countNonZero(own_(r))) / in;
  }

  // Whether what lies in these rows beside the object differs from it, or is out of the picture.
  bool ends(int first, int last) const {
    constexpr double kMost = 0.5;
    return share({box_.x, first, box_.width, last - first}).value_or(0) <= kMost;
  }

  void grow_rows() {
    const int gap = std::max<int>(4, 0.6 * step_);
    int top = box_.y, bottom = box_.br().y;
    for (int y = top - 1; y >= std::max(0, top - gap); --y)
      if (belongs({comb_.x, y, comb_.width, 1})) top = y;
    for (int y = bottom; y < std::min(own_.rows, bottom + gap); ++y)
      if (belongs({comb_.x, y, comb_.width, 1})) bottom = y + 1;
    box_.y = top;
    box_.height = bottom - top;
  }

  void grow_columns() {
    // Between fine marks, colors are mixed, so the rest of the width tells.
    cv::Rect rest = box_;
    if (const int above = comb_.y - box_.y, below = box_.br().y - comb_.br().y; std::max(above, below) >= 4)
      rest = above > below ? cv::Rect(0, box_.y, 1, above) : cv::Rect(0, comb_.br().y, 1, below);
    const int gap = box_.height / 2;  // a stone may lie on it
    int left = box_.x, right = box_.br().x;
    for (int x = left - 1; x >= std::max(0, left - gap); --x)
      if (belongs({x, rest.y, 1, rest.height})) left = x;
    for (int x = right; x < std::min(own_.cols, right + gap); ++x)
      if (belongs({x, rest.y, 1, rest.height})) right = x + 1;
    box_.x = left;
    box_.width = right - left;
  }

  bool belongs(const cv::Rect& line) const { return share(line).value_or(0) >= 0.55; }

  static constexpr int kMargin = 3, kRim = 6;  // pixels
  double step_;
  cv::Rect comb_, box_;
  cv::Mat turned_, inside_, own_;
};

// The strongest comb at angles near that of `comb`, to a quarter of a degree.
Comb refined(const cv::Mat& gray, const Comb& coarse) {
  const auto middle_of = [](const Comb& c, const TurnedFrame& frame) {
    return frame.in_picture((c.left + c.right) / 2.0, (c.top + c.bottom) / 2.0);
  };
  // What is around it suffices.
  const TurnedFrame whole(gray.size(), coarse.angle);
  std::vector<cv::Point> corners;
  const int margin = std::max(20, (coarse.right - coarse.left) / 4);
  for (const int x : {coarse.left - margin, coarse.right + margin})
    for (const int y : {coarse.top - margin, coarse.bottom + margin})
      corners.emplace_back(whole.in_picture(x, y));
  const cv::Rect window = cv::boundingRect(corners) & cv::Rect({0, 0}, gray.size());
  const cv::Mat around = gray(window);
  const cv::Point2d middle = middle_of(coarse, whole) - cv::Point2d(window.tl());
  Comb best = coarse;
  for (const double turn : {1.0, 0.5, 0.25}) {
    const double start = best.angle;
    for (const double side : {-turn, turn}) {
      const TurnedFrame frame(around.size(), start + side * kDegree);
      for (Comb c : find_combs(around, frame.angle)) {
        const cv::Point2d p = middle_of(c, frame);
        if (cv::norm(p - middle) >= (c.right - c.left) / 2.0 || c.weight() <= best.weight()) continue;
        // In the frame of the whole picture.
        const TurnedFrame all(gray.size(), c.angle);
        const cv::Point2d q = all.in_frame(p + cv::Point2d(window.tl()));
        const int length = c.right - c.left, rows = c.bottom - c.top;
        c.left = std::lround(q.x - length / 2.0);
        c.right = c.left + length;
        c.top = std::lround(q.y - rows / 2.0);
        c.bottom = c.top + rows;
        best = c;
      }
    }
  }
  return best;
}

std::vector<cv::Point> corners_of(const TurnedFrame& frame, const cv::Rect& box, double scale) {
  std::vector<cv::Point> out;
  for (const auto& [x, y] : {std::pair{box.x - 1, box.y - 1},
                             {box.br().x, box.y - 1},
                             {box.br().x, box.br().y},
                             {box.x - 1, box.br().y}}) {
    const cv::Point2d p = frame.in_picture(x, y);
    out.emplace_back(round_nearest((p.x + 0.5) / scale - 0.5), round_nearest((p.y + 0.5) / scale - 0.5));
  }
  return out;
}

bool lies_on(const cv::Mat& mask, const TurnedFrame& frame, const Comb& c) {
  const cv::Point2d p = frame.in_picture((c.left + c.right) / 2.0, (c.top + c.bottom) / 2.0);
  const cv::Rect whole({0, 0}, mask.size());
  const cv::Point q(static_cast<int>(p.x), static_cast<int>(p.y));
  return whole.contains(q) && mask.at<std::uint8_t>(q) != 0;
}

// The corners of the object around a comb, at the angle that fits it best; empty if it is none. `scale`: of
// the picture.
std::vector<cv::Point> object_around(const cv::Mat& levels, const Comb& comb, double scale) {
  const TurnedFrame own(levels.size(), comb.angle);
  const cv::Point2d middle = own.in_picture((comb.left + comb.right) / 2.0, (comb.top + comb.bottom) / 2.0);
  std::vector<cv::Point> best;
  double fit = 0;
  for (const double turn : {0.0, -0.5, 0.5, -1.0, 1.0, -1.5, 1.5}) {
    const TurnedFrame frame(levels.size(), comb.angle + turn * kDegree);
    const cv::Point2d p = frame.in_frame(middle);
    Comb c = comb;
    const int length = comb.right - comb.left, rows = comb.bottom - comb.top;
    c.left = std::lround(p.x - length / 2.0);
    c.right = c.left + length;
    c.top = std::lround(p.y - rows / 2.0);
    c.bottom = c.top + rows;
    Body body(levels, frame, c);
    const auto box = body.grow();
    if (box && body.fit() > fit) {
      fit = body.fit();
      best = corners_of(frame, *box, scale);
    }
    if (turn == 0 && !box) break;
  }
  return best;
}

// Adds what is found in a reduction of the picture.
void find_at_scale(const cv::Mat& levels, double scale, cv::Mat& taken,
                   std::vector<std::vector<cv::Point>>& found, const Work& work) {
  cv::Mat small, gray;
  if (scale < 1)
    cv::resize(levels, small, {}, scale, scale, cv::INTER_AREA);
  else
    small = levels;
  cv::cvtColor(small, gray, cv::COLOR_RGB2GRAY);
  constexpr int kAngles = 60;
  std::vector<std::vector<Comb>> at_angle(kAngles);
  work.parallel(kAngles, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) at_angle[k] = find_combs(gray, 180.0 / kAngles * k * kDegree);
  });
  std::vector<Comb> combs;
  for (const auto& some : at_angle) combs.insert(combs.end(), some.begin(), some.end());
  std::stable_sort(combs.begin(), combs.end(),
                   [](const Comb& a, const Comb& b) { return a.weight() > b.weight(); });
  constexpr std::size_t kMost = 24;  // of a periodic picture
  if (combs.size() > kMost) combs.resize(kMost);
  cv::Mat mask;
  for (const Comb& coarse : combs) {
    cv::resize(taken, mask, small.size(), 0, 0, cv::INTER_NEAREST);
    if (lies_on(mask, TurnedFrame(small.size(), coarse.angle), coarse)) continue;
    const auto corners =
        object_around(small, refined(gray, coarse), static_cast<double>(small.cols) / levels.cols);
    if (corners.empty()) continue;
    found.push_back(corners);
    cv::fillConvexPoly(taken, found.back(), cv::Scalar(255));
  }
}

}  // namespace

std::vector<std::vector<cv::Point>> find_scales(const cv::Mat& levels, const std::vector<cv::Rect>& known,
                                                const Work& work) {
  constexpr double kLonger =
      1600;  // pixels, enough for a millimeter of 4 pixels on a ruler along the picture
  constexpr int kLeast = 64;
  std::vector<std::vector<cv::Point>> found;
  if (std::min(levels.cols, levels.rows) < kLeast) return found;
  cv::Mat taken(levels.size(), CV_8U, cv::Scalar(0));
  for (const cv::Rect& r : known) taken(r).setTo(255);
  const double scale = std::min(1.0, kLonger / std::max(levels.cols, levels.rows));
  find_at_scale(levels, scale, taken, found, work);
  find_at_scale(levels, scale / 3, taken, found, work);  // for wide steps
  return found;
}

}  // namespace terrazzo::segment

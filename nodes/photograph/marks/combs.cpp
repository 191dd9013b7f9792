#include "nodes/photograph/marks/combs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "nodes/data/indices.h"

namespace terrazzo::segment {
namespace {

constexpr int kRowStep = 2;  // every second row is looked at

struct Edge {
  double at = 0;
  bool rising = false;
  double before = 0, after = 0;  // the extreme lightness on both sides
};

// Finds the edges along rows of one length: where a row crosses its mean over a window, between values that
// are clearly apart.
class EdgeFinder {
 public:
  explicit EdgeFinder(int length)
      : n_(length),
        row_(n_ + 2 * kWide),
        sums_(row_.size() + 1),
        squares_(sums_.size()),
        above_(n_),
        least_(n_) {}

  const std::vector<Edge>& operator()(const std::uint8_t* row) {
    compare(row);
    edges_.clear();
    int state = 0;
    float last = 0, extreme = 0;
    double crossing = 0;
    for (int i = 0; i < n_; ++i) {
      const float d = above_[i];
      if ((last < 0) != (d < 0)) crossing = i - 1 + static_cast<double>(last / (last - d));
      last = d;
      const int now = d * d <= least_[i] ? 0 : d > 0 ? 1 : -1;
      if (now != 0 && now != state) {
        if (!edges_.empty()) edges_.back().after = extreme;
        if (state != 0) edges_.push_back({crossing, now > 0, extreme, 0});
        state = now;
        extreme = row[i];
      } else if (state > 0) {
        extreme = std::max<float>(extreme, row[i]);
      } else if (state < 0) {
        extreme = std::min<float>(extreme, row[i]);
      }
    }
    if (!edges_.empty()) edges_.back().after = extreme;
    return edges_;
  }

 private:
  // How far each pixel is above the mean near it, and the square of what is visible there.
  void compare(const std::uint8_t* row) {
    std::fill_n(row_.begin(), kWide, row[0]);
    std::copy_n(row, n_, row_.begin() + kWide);
    std::fill_n(row_.begin() + kWide + n_, kWide, row[n_ - 1]);
    for (std::size_t i = 0; i < row_.size(); ++i) {
      sums_[i + 1] = sums_[i] + row_[i];
      squares_[i + 1] = squares_[i] + row_[i] * row_[i];
    }
    constexpr int kNearSpan = 2 * kNear + 1, kWideSpan = 2 * kWide;
    for (int i = 0; i < n_; ++i) {
      const int at = i + kWide;
      above_[i] =
          static_cast<float>(row_[at]) - (sums_[at + kNear + 1] - sums_[at - kNear]) * (1.0f / kNearSpan);
      const float mean = (sums_[at + kWide] - sums_[at - kWide]) * (1.0f / kWideSpan),
                  square = (squares_[at + kWide] - squares_[at - kWide]) * (1.0f / kWideSpan);
      least_[i] = std::max(kVisible * kVisible, kOfSpread * kOfSpread * (square - mean * mean));
    }
  }

  static constexpr int kNear = 24, kWide = 80;            // pixels to each side
  static constexpr float kVisible = 8, kOfSpread = 0.4f;  // levels; of the standard deviation
  int n_;
  std::vector<std::uint8_t> row_;
  std::vector<std::int32_t> sums_, squares_;
  std::vector<float> above_, least_;
  std::vector<Edge> edges_;
};

struct Run {
  int row = 0;
  double first = 0, last = 0, step = 0;
  int marks = 0;
};

// Whether the light values of the edges repeat, and the dark ones.
bool two_levels(const Edge* const* edges, int count) {
  constexpr double kSpread = 0.22;
  double sum[2] = {0, 0}, square[2] = {0, 0};
  for (int k = 0; k < count; ++k) {
    const double low = std::min(edges[k]->before, edges[k]->after),
                 high = std::max(edges[k]->before, edges[k]->after);
    sum[0] += low;
    sum[1] += high;
    square[0] += low * low;
    square[1] += high * high;
  }
  const double apart = (sum[1] - sum[0]) / count;
  for (int k = 0; k < 2; ++k) {
    const double mean = sum[k] / count;
    if (square[k] / count - mean * mean > kSpread * kSpread * apart * apart) return false;
  }
  return true;
}

// Appends the runs of equal distances among these edges.
void find_runs(const std::vector<const Edge*>& edges, int row, int least, std::vector<Run>& runs) {
  constexpr double kShortestStep = 3.5, kAgree = 0.06, kPixels = 0.35;
  const int n = edges.size();
  for (int i = 0; i + least <= n;) {
    double step = edges[i + 1]->at - edges[i]->at;
    int j = i + 1;
    while (j + 1 < n && std::abs(edges[j + 1]->at - edges[j]->at - step) <= std::max(0.15 * step, 0.9)) {
      ++j;
      step = (edges[j]->at - edges[i]->at) / (j - i);
    }
    const int marks = j - i + 1;
    if (marks < least || step < kShortestStep) {
      ++i;
      continue;
    }
    double residual = 0;
    for (int k = i; k <= j; ++k)
      residual += std::pow(edges[k]->at - edges[i]->at - step * (k - i), 2) / marks;
    if (std::sqrt(residual) <= std::max(kAgree * step, kPixels) && two_levels(&edges[i], marks))
      runs.push_back({row, edges[i]->at, edges[j]->at, step, marks});
    i = j;
  }
}

bool same_marks(const Run& a, const Run& b) {
  if (std::abs(a.step - b.step) > 0.04 * a.step) return false;
  if (std::min(a.last, b.last) - std::max(a.first, b.first) < 4 * a.step) return false;
  // At the middle of what both show, so that a small difference of the steps does not add up.
  const double middle = (std::min(a.last, b.last) + std::max(a.first, b.first)) / 2;
  const auto phase = [&](const Run& r) { return (middle - r.first) / r.step; };
  const double d = phase(a) - phase(b);
  return std::abs(d - std::round(d)) <= std::max(0.12, 0.6 / a.step);
}

// Joins runs of neighboring rows.
std::vector<Comb> combs_of(const std::vector<Run>& runs, double angle) {
  constexpr int kLeastRows = 3;
  struct Open {
    Run last;
    Comb comb;
  };
  std::vector<Open> open;
  std::vector<Comb> combs;
  const auto close = [&](int row) {
    std::erase_if(open, [&](const Open& o) {
      if (o.last.row >= row - 2 * kRowStep) return false;
      if (o.comb.rows >= kLeastRows) combs.push_back(o.comb);
      return true;
    });
  };
  for (const Run& r : runs) {
    close(r.row);
    const auto known = std::find_if(
        open.begin(), open.end(), [&](const Open& o) { return o.last.row < r.row && same_marks(o.last, r); });
    const int left = static_cast<int>(r.first), right = static_cast<int>(r.last) + 2;
    if (known == open.end()) {
      open.push_back({r, {angle, left, right, r.row, r.row + kRowStep, r.step, r.marks, 1}});
      continue;
    }
    Comb& c = known->comb;
    c.left = std::min(c.left, left);
    c.right = std::max(c.right, right);
    c.bottom = r.row + kRowStep;
    if (r.marks > c.marks) {
      c.marks = r.marks;
      c.step = r.step;
    }
    ++c.rows;
    known->last = r;
  }
  close(1 << 30);
  return combs;
}

}  // namespace

TurnedFrame::TurnedFrame(const cv::Size& picture, double turn) : angle(turn) {
  const double c = std::cos(turn), s = std::sin(turn), w = picture.width, h = picture.height;
  size = {round_up(w * std::abs(c) + h * std::abs(s)), round_up(w * std::abs(s) + h * std::abs(c))};
  const double x = (size.width - 1) / 2.0, y = (size.height - 1) / 2.0, u = (w - 1) / 2, v = (h - 1) / 2;
  to_frame = {c, s, x - c * u - s * v, -s, c, y + s * u - c * v};
  to_picture = {c, -s, u - c * x + s * y, s, c, v - s * x - c * y};
}

cv::Mat TurnedFrame::turned(const cv::Mat& picture) const {
  if (angle == 0) return picture;
  cv::Mat out;
  cv::warpAffine(picture, out, to_picture, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  return out;
}

cv::Point2d TurnedFrame::in_picture(double x, double y) const {
  return {to_picture(0, 0) * x + to_picture(0, 1) * y + to_picture(0, 2),
          to_picture(1, 0) * x + to_picture(1, 1) * y + to_picture(1, 2)};
}

cv::Point2d TurnedFrame::in_frame(const cv::Point2d& p) const {
  return {to_frame(0, 0) * p.x + to_frame(0, 1) * p.y + to_frame(0, 2),
          to_frame(1, 0) * p.x + to_frame(1, 1) * p.y + to_frame(1, 2)};
}

std::vector<Comb> find_combs(const cv::Mat& gray, double angle) {
  const TurnedFrame frame(gray.size(), angle);
  // Only the rows that are looked at.
  cv::Matx23d some = frame.to_picture;
  some(0, 1) *= kRowStep;
  some(1, 1) *= kRowStep;
  cv::Mat turned;
  cv::warpAffine(gray, turned, some, {frame.size.width, (frame.size.height + kRowStep - 1) / kRowStep},
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
  constexpr int kLeastMarks = 10, kLeastBlocks = 9;
  EdgeFinder find_edges(turned.cols);
  std::vector<Run> runs;
  std::vector<const Edge*> rising, all;
  for (int k = 0; k < turned.rows; ++k) {
    const int y = k * kRowStep;
    const std::vector<Edge>& edges = find_edges(turned.ptr<std::uint8_t>(k));
    rising.clear();
    all.clear();
    for (const Edge& e : edges) {
      all.push_back(&e);
      if (e.rising) rising.push_back(&e);
    }
    find_runs(rising, y, kLeastMarks, runs);
    find_runs(all, y, kLeastBlocks, runs);
  }
  return combs_of(runs, angle);
}

}  // namespace terrazzo::segment

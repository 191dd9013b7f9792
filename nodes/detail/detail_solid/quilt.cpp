#include "nodes/detail/detail_solid/quilt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/periodic.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::detail_solid {
namespace {

constexpr std::uint64_t kQuiltStream = 0x7175696c;
constexpr int kSides[] = {48, 36, 27, 21, 15, 12};  // of pieces, pixels; multiples of 3
constexpr double kShown = 0.5;                      // share of the known places that pieces must show
constexpr float kWorn = 0.25F;       // how much worse a piece becomes with each use of its place
constexpr int kTried = 300;          // pieces for each place
constexpr float kAlmostBest = 1.1F;  // of the least difference: any of these pieces will do

// The share of the known places that lie in known squares.
double share_in_squares(const PartialPicture& p, int side) {
  cv::Mat known(p.height, p.width, CV_8U), squares;
  std::copy(p.known.begin(), p.known.end(), known.data);
  const cv::Mat square = cv::Mat::ones(side, side, CV_8U);
  cv::morphologyEx(known, squares, cv::MORPH_OPEN, square, {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  return double(cv::countNonZero(squares)) / std::max(1, cv::countNonZero(known));
}

// The upper left corners of all squares that are known.
std::vector<std::size_t> known_squares(const PartialPicture& p, int side) {
  std::vector<int> sum(pixels_in(p.width + 1, p.height + 1), 0);
  const auto at = [&](int x, int y) -> int& { return sum[pixel_at(x, y, p.width + 1)]; };
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x)
      at(x + 1, y + 1) = at(x, y + 1) + at(x + 1, y) - at(x, y) + p.known[pixel_at(x, y, p.width)];
  std::vector<std::size_t> corners;
  for (int y = 0; y + side <= p.height; ++y)
    for (int x = 0; x + side <= p.width; ++x)
      if (at(x + side, y + side) - at(x, y + side) - at(x + side, y) + at(x, y) == side * side)
        corners.push_back(pixel_at(x, y, p.width));
  return corners;
}

class Quilt {
 public:
  Quilt(const PartialPicture& from, int side, std::vector<std::size_t> pieces, int width, int height)
      : from_(from), pieces_(std::move(pieces)), side_(side), overlap_(side / 3), step_(side - side / 3) {
    across_ = std::max(2, round_nearest(width / double(step_)));
    down_ = std::max(2, round_nearest(height / double(step_)));
    out_.width = across_ * step_;
    out_.height = down_ * step_;
    out_.value.assign(pixels_in(out_.width, out_.height), Vec3f::Zero());
    out_.known.assign(out_.value.size(), 0);
    uses_.assign(from.value.size(), 0);
  }

  PartialPicture sew(std::uint64_t seed, const Work& work) {
    for (int row = 0; row < down_; ++row)
      for (int column = 0; column < across_; ++column) {
        work.check();
        Random random(seed, kQuiltStream, static_cast<std::uint64_t>(row) * across_ + column);
        const std::size_t corner = pick(column * step_, row * step_, random);
        add(column, row, corner);
        ++uses_[cell_of(corner)];
      }
    return std::move(out_);
  }

 private:
  std::size_t place(int x, int y) const {
    return pixel_at(wrap_index(x, out_.width), wrap_index(y, out_.height), out_.width);
  }
  const Vec3f& piece_at(std::size_t corner, int x, int y) const {
    return from_.value[corner + pixel_at(x, y, from_.width)];
  }
  float difference(std::size_t corner, int left, int top, int x, int y) const {
    const std::size_t i = place(left + x, top + y);
    return out_.known[i] ? (out_.value[i] - piece_at(corner, x, y)).squaredNorm() : 0;
  }
  // All pieces with corners in a cell are almost the same.
  std::size_t cell_of(std::size_t corner) const {
    const int x = static_cast<int>(corner % from_.width) / overlap_;
    const int y = static_cast<int>(corner / from_.width) / overlap_;
    return pixel_at(x, y, from_.width);
  }
  // A piece that differs little from what is already there and was seldom used.
  std::size_t pick(int left, int top, Random& random) const {
    std::vector<std::size_t> tried;
    std::vector<float> cost;
    for (int k = 0; k < kTried; ++k) {
      tried.push_back(pieces_[random.below(pieces_.size())]);
      float sum = 0;
      for (int y = 0; y < side_; ++y)
        for (int x = 0; x < side_; ++x) sum += difference(tried.back(), left, top, x, y);
      cost.push_back(sum * (1 + kWorn * uses_[cell_of(tried.back())]));
    }
    const float most = kAlmostBest * *std::min_element(cost.begin(), cost.end());
    std::vector<std::size_t> good;
    for (int k = 0; k < kTried; ++k)
      if (cost[k] <= most) good.push_back(tried[k]);
    return good[random.below(good.size())];
  }

  // For each line along an edge, how many pixels from the edge stay as they are: the path of least difference
  // through the overlap. difference_at(line, pixel from the edge).
  template <class F>
  std::vector<int> cut(F&& difference_at) const {
    std::vector<std::vector<float>> sum(side_, std::vector<float>(overlap_));
    for (int line = 0; line < side_; ++line)
      for (int k = 0; k < overlap_; ++k) {
        float before = line == 0 ? 0 : std::numeric_limits<float>::max();
        for (int j = std::max(0, k - 1); line > 0 && j <= std::min(overlap_ - 1, k + 1); ++j)
          before = std::min(before, sum[line - 1][j]);
        sum[line][k] = before + difference_at(line, k);
      }
    std::vector<int> path(side_);
    for (int line = side_ - 1; line >= 0; --line) {
      int from = 0;
      int to = overlap_ - 1;
      if (line < side_ - 1) {
        from = std::max(0, path[line + 1] - 1);
        to = std::min(overlap_ - 1, path[line + 1] + 1);
      }
      path[line] = static_cast<int>(std::min_element(sum[line].begin() + from, sum[line].begin() + to + 1) -
                                    sum[line].begin());
    }
    return path;
  }

  void add(int column, int row, std::size_t corner) {
    const int left = column * step_;
    const int top = row * step_;
    const auto differs = [&](int x, int y) { return difference(corner, left, top, x, y); };
    const int last = side_ - 1;
    const std::vector<int> none(side_, 0);
    const auto from_left = column > 0 ? cut([&](int y, int k) { return differs(k, y); }) : none;
    const auto from_top = row > 0 ? cut([&](int x, int k) { return differs(x, k); }) : none;
    const auto from_right =
        column == across_ - 1 ? cut([&](int y, int k) { return differs(last - k, y); }) : none;
    const auto from_bottom =
        row == down_ - 1 ? cut([&](int x, int k) { return differs(x, last - k); }) : none;
    for (int y = 0; y < side_; ++y)
      for (int x = 0; x < side_; ++x) {
        const bool kept =
            x < from_left[y] || last - x < from_right[y] || y < from_top[x] || last - y < from_bottom[x];
        const std::size_t i = place(left + x, top + y);
        if (kept && out_.known[i]) continue;
        out_.value[i] = piece_at(corner, x, y);
        out_.known[i] = 1;
      }
  }

  const PartialPicture& from_;
  std::vector<std::size_t> pieces_;  // their upper left corners
  int side_, overlap_, step_;        // pixels
  int across_ = 0, down_ = 0;        // pieces
  std::vector<float> uses_;          // by each cell
  PartialPicture out_;
};

}  // namespace

PartialPicture quilt_picture(const PartialPicture& from, int width, int height, std::uint64_t seed,
                             const Work& work) {
  for (const int side : kSides) {
    if (share_in_squares(from, side) < kShown) continue;
    return Quilt(from, side, known_squares(from, side), width, height).sew(seed, work);
  }
  return {};
}

}  // namespace terrazzo::detail_solid

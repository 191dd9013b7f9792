#include "nodes/photograph/segment/measure/tilt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "nodes/data/indices.h"

namespace terrazzo::segment {
namespace {

constexpr std::size_t kFewStones = 60;  // the sizes of fewer change as much by chance as by 30°
constexpr double kSureSlope = 3.5;      // standard errors; by chance, one picture in some hundreds has more
// Sixteen parts of the picture tell their own spread badly: Student's t with 14 degrees of freedom
// exceeds 4.5 as often as a normal variable exceeds 3.5.
constexpr double kFewParts = 4.5 / 3.5;
constexpr int kLines = 18;         // every 10°, finer than the direction can be told
constexpr int kParts = 4;          // of the picture along each side
constexpr double kHalfView = 30;   // degrees, half the field of view of a phone's main camera
constexpr double kSlightTilt = 1;  // degrees; outlines err by more

struct SizedStone {
  const Profile* profile = nullptr;
  double diameter = 0;  // of the whole silhouette, mm
  int part = 0;         // of the picture
};

std::vector<SizedStone> sized_stones(const Profiles& p) {
  std::vector<SizedStone> out;
  for (const Profile& one : p.profiles) {
    if (one.touches_border || one.contour.size() < 3 || one.area <= 0) continue;
    const auto part = [](double at, double size) {
      return std::clamp(round_down(kParts * at / size), 0, kParts - 1);
    };
    out.push_back({&one, std::sqrt(std::max(one.whole, one.area)),
                   part(one.centroid.y(), p.window.y()) * kParts + part(one.centroid.x(), p.window.x())});
  }
  return out;
}

// The extent of the silhouette along a line. Of a stone that is partly hidden, the visible extent grows as
// its diameter does.
double extent(const SizedStone& stone, const Vec2& line) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec2& p : stone.profile->contour) {
    low = std::min(low, p.dot(line));
    high = std::max(high, p.dot(line));
  }
  return (high - low) * stone.diameter / std::sqrt(stone.profile->area);
}

struct SizeSlope {
  double slope = 0;  // of ln width across the line, per mm along it
  double error = 0;  // standard error
};

SizeSlope slope_along(const std::vector<SizedStone>& stones, const Vec2& line) {
  const Vec2 across(-line.y(), line.x());
  std::vector<double> at, size;
  double all = 0, mean_at = 0, mean_size = 0;
  for (const SizedStone& s : stones) {
    at.push_back(s.profile->centroid.dot(line));
    size.push_back(std::log(std::max(extent(s, across), std::numeric_limits<double>::min())));
    all += s.diameter;
    mean_at += s.diameter * at.back();
    mean_size += s.diameter * size.back();
  }
  mean_at /= all;
  mean_size /= all;
  double xx = 0, xy = 0;
  for (std::size_t i = 0; i < stones.size(); ++i) {
    xx += stones[i].diameter * (at[i] - mean_at) * (at[i] - mean_at);
    xy += stones[i].diameter * (at[i] - mean_at) * (size[i] - mean_size);
  }
  if (xx <= 0) return {0, std::numeric_limits<double>::infinity()};
  const double slope = xy / xx;
  std::array<double, kParts * kParts> sums{};
  double alone = 0, together = 0;
  for (std::size_t i = 0; i < stones.size(); ++i) {
    const double x = at[i] - mean_at;
    const double score = stones[i].diameter * x * (size[i] - mean_size - slope * x);
    alone += score * score;
    sums[stones[i].part] += score;
  }
  for (const double sum : sums) together += sum * sum;
  const double n = stones.size(), parts = sums.size();
  return {
      slope,
      std::max(std::sqrt(alone * n / (n - 2)), kFewParts * std::sqrt(together * parts / (parts - 1))) / xx};
}

}  // namespace

TiltEstimate estimated_tilt(const Profiles& p) {
  const double longer = p.window.maxCoeff();
  if (!(p.window.minCoeff() > 0)) return {};  // unknown
  const std::vector<SizedStone> stones = sized_stones(p);
  if (stones.size() < kFewStones) return {};
  constexpr double kDegree = std::numbers::pi / 180;
  SizeSlope best{0, 1};
  double best_angle = 0;
  for (int k = 0; k < kLines; ++k) {
    const double angle = std::numbers::pi * k / kLines;
    SizeSlope here = slope_along(stones, {std::cos(angle), std::sin(angle)});
    here.error += 1e-9 / longer;  // equal stones have no errors
    if (std::abs(here.slope) * best.error <= std::abs(best.slope) * here.error) continue;
    best = here;
    best_angle = angle;
  }
  const double change = std::abs(best.slope);
  if (change <= kSureSlope * best.error) return {};
  const double edge =
      0.5 * (std::abs(std::cos(best_angle)) * p.window.x() + std::sin(best_angle) * p.window.y());
  const double focal = 0.5 * longer / std::tan(kHalfView * kDegree);
  const double degrees = std::atan(focal / edge * std::tanh(change * edge)) / kDegree;
  if (degrees < kSlightTilt) return {};
  const double direction = std::round(best_angle / kDegree) + (best.slope > 0 ? 180 : 0);
  return {degrees, direction, std::exp(2 * change * edge)};
}

}  // namespace terrazzo::segment

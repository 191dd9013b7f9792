#include "nodes/packing/cells/joints.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "nodes/data/indices.h"

namespace terrazzo::tessellation {
namespace {

// 1 / sin θ where θ has the density sin²θ, that of planes weighted by the length of the film that they show.
constexpr double kOblique = 1.09;
constexpr double kPointSpacing = 1.0 / 40;  // of points on outlines, in mean diameters
constexpr double kSearch = 0.5;             // farthest neighbor, in mean diameters

struct OutlinePoint {
  Vec2 at;
  std::int32_t profile;
};

std::vector<OutlinePoint> points_on(const Profiles& profiles, double spacing) {
  std::vector<OutlinePoint> points;
  for (std::size_t p = 0; p < profiles.profiles.size(); ++p) {
    const auto& contour = profiles.profiles[p].contour;
    for (std::size_t k = 0; k < contour.size(); ++k) {
      const Vec2 &a = contour[k], &b = contour[(k + 1) % contour.size()];
      const int pieces = std::max(1, round_up((b - a).norm() / spacing));
      for (int i = 0; i < pieces; ++i)
        points.push_back({a + (b - a) * i / pieces, static_cast<std::int32_t>(p)});
    }
  }
  return points;
}

class Grid {
 public:
  Grid(const std::vector<OutlinePoint>& points, const Profiles& profiles, double cell)
      : points_(points), profiles_(profiles), cell_(cell) {
    for (std::size_t k = 0; k < points.size(); ++k)
      cells_[key(section(points[k]), column(points[k].at[0]), column(points[k].at[1]))].push_back(k);
  }

  // The distance to the nearest point of another profile of the section, or `cell` if it is farther.
  double nearest_other(const OutlinePoint& p) const {
    double best = cell_;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const auto it = cells_.find(key(section(p), column(p.at[0]) + dx, column(p.at[1]) + dy));
        if (it == cells_.end()) continue;
        for (std::size_t k : it->second)
          if (points_[k].profile != p.profile) best = std::min(best, (points_[k].at - p.at).norm());
      }
    return best;
  }

 private:
  const std::vector<OutlinePoint>& points_;
  const Profiles& profiles_;
  double cell_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;

  int section(const OutlinePoint& p) const { return profiles_.profiles[p.profile].section; }
  int column(double x) const { return round_down(x / cell_); }
  static std::uint64_t key(int section, int x, int y) {
    return static_cast<std::uint64_t>(section) << 48 ^ static_cast<std::uint64_t>(x + (1 << 23)) << 24 ^
           static_cast<std::uint64_t>(y + (1 << 23));
  }
};

}  // namespace

Joints measure_joints(const Profiles& profiles, const Work& work) {
  double area = 0, count = 0;
  for (const Profile& p : profiles.profiles)
    if (!p.contour.empty()) {
      area += p.area;
      ++count;
    }
  if (count < 2 || !(area > 0)) return {};
  const double mean = std::sqrt(4 / std::numbers::pi * area / count);
  const auto points = points_on(profiles, kPointSpacing * mean);
  const double reach = kSearch * mean;
  const Grid grid(points, profiles, reach);
  std::vector<double> distance(points.size());
  work.parallel(points.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) distance[k] = grid.nearest_other(points[k]);
  });
  std::erase_if(distance, [&](double d) { return d >= reach; });
  if (distance.empty()) return {};
  std::sort(distance.begin(), distance.end());
  const auto quantile = [&](double q) {
    return distance[static_cast<std::size_t>(q * (distance.size() - 1))];
  };
  Joints out;
  out.thickness = quantile(0.5) / kOblique;
  if (out.thickness > 0)
    out.variation = std::min(1.0, 0.5 * (quantile(0.75) - quantile(0.25)) / quantile(0.5));
  return out;
}

}  // namespace terrazzo::tessellation

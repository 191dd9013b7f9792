#include "nodes/shapes/shape_estimate/inscribed.h"

#include <algorithm>

#include "nodes/common/geometry/mesh/loop.h"

namespace terrazzo::shape_estimate {
namespace {

// Moves each corner to where it makes the polygon largest, until none moves. Along a convex hull, the
// distance from a chord has one maximum.
void enlarge(const std::vector<Vec2>& hull, std::vector<std::size_t>& corner) {
  constexpr int kMost = 12;  // sweeps
  const std::size_t n = hull.size(), k = corner.size();
  for (int sweep = 0; sweep < kMost; ++sweep) {
    bool moved = false;
    for (std::size_t j = 0; j < k; ++j) {
      const std::size_t from = corner[(j + k - 1) % k], to = corner[(j + 1) % k];
      const Vec2 side = hull[to] - hull[from];
      const auto height = [&](std::size_t i) { return cross(hull[i] - hull[from], side); };
      double most = height(corner[j]);
      for (const std::size_t step : {std::size_t{1}, n - 1}) {  // ahead and back
        std::size_t next = (corner[j] + step) % n;
        while (next != from && next != to && height(next) > most) {
          most = height(next);
          corner[j] = next;
          moved = true;
          next = (next + step) % n;
        }
      }
    }
    if (!moved) return;
  }
}

double area_of(const std::vector<Vec2>& hull, const std::vector<std::size_t>& corner) {
  double twice = 0;
  for (std::size_t j = 0; j < corner.size(); ++j)
    twice += cross(hull[corner[j]], hull[corner[(j + 1) % corner.size()]]);
  return twice / 2;
}

double largest_inscribed(const std::vector<Vec2>& hull, std::size_t corners) {
  constexpr std::size_t kStarts = 4;
  double largest = 0;
  for (std::size_t s = 0; s < kStarts; ++s) {
    std::vector<std::size_t> corner(corners);
    for (std::size_t j = 0; j < corners; ++j)
      corner[j] = (j * kStarts + s) * hull.size() / (corners * kStarts);
    enlarge(hull, corner);
    largest = std::max(largest, area_of(hull, corner));
  }
  return largest;
}

}  // namespace

std::array<double, kInscribed.size()> inscribed_shares(const std::vector<Vec2>& points) {
  std::array<double, kInscribed.size()> out{};
  const Loop hull = hull_of(points);
  const double area = loop_area(hull);
  if (!(area > 0)) return out;
  for (std::size_t i = 0; i < kInscribed.size(); ++i) {
    const std::size_t corners = kInscribed[i];
    out[i] = hull.size() <= corners ? 1 : std::min(1.0, largest_inscribed(hull, corners) / area);
  }
  return out;
}

}  // namespace terrazzo::shape_estimate

#include "nodes/common/geometry/mesh/loop.h"

#include <algorithm>
#include <cmath>

namespace terrazzo {
namespace {

// Sorts by x, then y. Along an outline x rises and falls in few long runs, which are merged.
void sort_by_x(Loop& p) {
  const auto less = [](const Vec2& a, const Vec2& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::vector<std::ptrdiff_t> runs = {0};  // where they begin, and the end of the last
  for (auto begin = p.begin(); begin != p.end(); runs.push_back(begin - p.begin())) {
    auto end = begin + 1;
    const bool falls = end != p.end() && less(*end, *begin);
    while (end != p.end() && less(*end, *(end - 1)) == falls) ++end;
    if (falls) std::reverse(begin, end);
    begin = end;
  }
  while (runs.size() > 2) {
    std::vector<std::ptrdiff_t> longer = {0};
    for (std::size_t k = 0; k + 1 < runs.size(); k += 2) {
      const std::size_t last = std::min(k + 2, runs.size() - 1);
      std::inplace_merge(p.begin() + runs[k], p.begin() + runs[k + 1], p.begin() + runs[last], less);
      longer.push_back(runs[last]);
    }
    runs = std::move(longer);
  }
}

}  // namespace

double turn_between(const Vec2& before, const Vec2& after) {
  return std::atan2(cross(before, after), before.dot(after));
}

double loop_area(const Loop& loop) {
  if (loop.size() < 3) return 0;
  double twice = 0;
  const Vec2 o = loop[0];  // a point of the loop, to lose no digits
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    const Vec2 a = loop[i] - o, b = loop[i + 1] - o;
    twice += cross(a, b);
  }
  return twice / 2;
}

double loop_perimeter(const Loop& loop) {
  double sum = 0;
  for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) sum += (loop[i] - loop[j]).norm();
  return sum;
}

bool loop_contains(const Loop& loop, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
    const Vec2 &a = loop[i], &b = loop[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

// Monotone chains (Andrew 1979).
Loop hull_of(Loop points) {
  if (points.size() < 3) return {};
  sort_by_x(points);
  Loop hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = hull.size();
    for (const Vec2& q : points) {
      while (hull.size() >= base + 2 && cross(hull.back() - hull[hull.size() - 2], q - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(q);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

double hull_area(Loop points) { return loop_area(hull_of(std::move(points))); }

}  // namespace terrazzo

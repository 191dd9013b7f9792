#include <algorithm>
#include <cmath>

#include "nodes/bodies/cutting/region.h"
#include "runtime/random.h"

namespace terrazzo::section {

namespace {

using Interval = std::pair<double, double>;  // parameter range along an edge, within 0 … 1

bool inside(const Region& region, const Vec2& p) {
  bool in = false;
  for (const Loop& l : region) in = in != loop_contains(l, p);
  return in;
}

bool apart(const Extent& e, const Vec2& p, const Vec2& q) {
  for (int k = 0; k < 2; ++k)
    if (std::min(p[k], q[k]) > e.hi[k] || std::max(p[k], q[k]) < e.lo[k]) return true;
  return false;
}

// Adds the parts of the edge p → q that lie within the region.
void cover(const Region& region, const Extent& extent, const Vec2& p, const Vec2& q,
           std::vector<double>& crossings, std::vector<Interval>& covered) {
  if (apart(extent, p, q)) return;
  crossings.clear();
  const Vec2 d = q - p;
  for (const Loop& l : region)
    for (std::size_t i = 0, j = l.size() - 1; i < l.size(); j = i++) {
      // Points on the line are treated as left of it, so that an outline crossing at a vertex is counted
      // once.
      const double sj = cross(d, l[j] - p), si = cross(d, l[i] - p);
      if ((sj >= 0) == (si >= 0)) continue;
      const Vec2 x = l[j] + (l[i] - l[j]) * (sj / (sj - si));
      const double t = (x - p).dot(d) / d.squaredNorm();
      if (t > 0 && t < 1) crossings.push_back(t);
    }
  if (crossings.empty()) {
    if (inside(region, (p + q) / 2)) covered.emplace_back(0, 1);
    return;
  }
  std::sort(crossings.begin(), crossings.end());
  crossings.push_back(1);
  // Test inside or outside at the middle of the widest interval, where rounding matters least.
  std::size_t widest = 0;
  double width = crossings[0];
  for (std::size_t i = 1; i < crossings.size(); ++i)
    if (crossings[i] - crossings[i - 1] > width) {
      widest = i;
      width = crossings[i] - crossings[i - 1];
    }
  const double middle = crossings[widest] - width / 2;
  bool in = inside(region, p + d * middle) == (widest % 2 == 0);
  double from = 0;
  for (double t : crossings) {
    if (in) covered.emplace_back(from, t);
    from = t;
    in = !in;
  }
}

// Sorts the intervals and joins those that overlap.
void merge(std::vector<Interval>& v) {
  std::sort(v.begin(), v.end());
  std::size_t n = 0;
  for (const Interval& i : v) {
    if (n && i.first <= v[n - 1].second)
      v[n - 1].second = std::max(v[n - 1].second, i.second);
    else
      v[n++] = i;
  }
  v.resize(n);
}

// The part of p → q within the window.
Interval in_window(const Vec2& p, const Vec2& q, double width, double height) {
  double lo = 0, hi = 1;
  const double size[2] = {width, height};
  for (int k = 0; k < 2; ++k) {
    const double d = q[k] - p[k];
    if (d == 0) {
      if (p[k] < 0 || p[k] > size[k]) return {1, 0};
      continue;
    }
    const double a = -p[k] / d, b = (size[k] - p[k]) / d;
    lo = std::max(lo, std::min(a, b));
    hi = std::min(hi, std::max(a, b));
  }
  return {lo, hi};
}

}  // namespace

double union_area(const std::vector<Region>& given, double width, double height) {
  // For coinciding outlines, as of packed boxes, "covered by another region" is undefined. A shift far below
  // any relevant length separates them.
  std::vector<Region> regions;
  for (std::size_t i = 0; i < given.size(); ++i) {
    Random random(0, 0, i);
    const double far = 1e-10 * (width + height), x = random.uniform(-far, far), y = random.uniform(-far, far);
    regions.push_back(translated(given[i], {x, y}));
  }
  std::vector<Extent> extents;
  std::vector<std::size_t> by_left(regions.size());
  double widest = 0;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    extents.push_back(region_extent(regions[i]));
    by_left[i] = i;
    widest = std::max(widest, extents[i].hi.x() - extents[i].lo.x());
  }
  std::sort(by_left.begin(), by_left.end(), [&](std::size_t a, std::size_t b) {
    return extents[a].lo.x() != extents[b].lo.x() ? extents[a].lo.x() < extents[b].lo.x() : a < b;
  });

  double twice = 0;
  std::vector<double> crossings;
  std::vector<Interval> covered;
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    near.clear();
    const Extent& e = extents[i];
    auto at = std::lower_bound(by_left.begin(), by_left.end(), e.lo.x() - widest,
                               [&](std::size_t a, double x) { return extents[a].lo.x() < x; });
    for (; at != by_left.end() && extents[*at].lo.x() <= e.hi.x(); ++at)
      if (*at != i && !apart(extents[*at], e.lo, e.hi)) near.push_back(*at);
    for (const Loop& l : regions[i])
      for (std::size_t k = 0, j = l.size() - 1; k < l.size(); j = k++) {
        const Vec2 &p = l[j], &q = l[k];
        const auto [lo, hi] = in_window(p, q, width, height);
        if (!(lo < hi)) continue;
        covered.clear();
        for (std::size_t n : near) cover(regions[n], extents[n], p, q, crossings, covered);
        merge(covered);
        double bare = hi - lo;
        for (const auto& [a, b] : covered) bare -= std::max(0.0, std::min(b, hi) - std::max(a, lo));
        twice += bare * cross(p, q);  // a part of an edge adds its share of the triangle of edge and origin
      }
  }
  const Vec2 corner[4] = {{0, 0}, {width, 0}, {width, height}, {0, height}};
  for (int side = 1; side < 3; ++side) {  // the two sides through the origin contribute no area
    const Vec2 &p = corner[side], &q = corner[side + 1];
    covered.clear();
    for (std::size_t i = 0; i < regions.size(); ++i) cover(regions[i], extents[i], p, q, crossings, covered);
    merge(covered);
    for (const auto& [a, b] : covered) twice += (b - a) * cross(p, q);
  }
  return twice / 2;
}

}  // namespace terrazzo::section

#include "nodes/bodies/cutting/region.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::section {

double region_area(const Region& region) {
  double area = 0;
  for (const Loop& l : region) area += loop_area(l);
  return area;
}

double region_perimeter(const Region& region) {
  double sum = 0;
  for (const Loop& l : region) sum += loop_perimeter(l);
  return sum;
}

Vec2 region_centroid(const Region& region) {
  const Vec2 o = region.at(0).at(0);  // an origin near the region keeps precision
  Vec2 moment = Vec2::Zero();
  double twice = 0;
  for (const Loop& l : region)
    for (std::size_t i = 0, j = l.size() - 1; i < l.size(); j = i++) {
      const Vec2 p = l[j] - o, q = l[i] - o;
      const double cross = p.x() * q.y() - p.y() * q.x();
      twice += cross;
      moment += cross * (p + q);
    }
  if (twice > 0) return o + moment / (3 * twice);
  const Extent e = region_extent(region);
  return (e.lo + e.hi) / 2;
}

Extent region_extent(const Region& region) {
  Extent e{region.at(0).at(0), region[0][0]};
  for (const Vec2& p : region[0]) {
    e.lo = e.lo.cwiseMin(p);
    e.hi = e.hi.cwiseMax(p);
  }
  return e;
}

Region translated(Region region, const Vec2& by) {
  for (Loop& l : region)
    for (Vec2& p : l) p += by;
  return region;
}

Region clipped(const Region& region, double width, double height) {
  Region result;
  for (const Loop& outline : region) {
    Loop loop = outline;
    for (int side = 0; side < 4 && !loop.empty(); ++side) {
      const int k = side / 2;
      const double bound = side % 2 ? (k ? height : width) : 0, sign = side % 2 ? -1 : 1;
      Loop kept;
      for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
        const double dj = sign * (loop[j][k] - bound), di = sign * (loop[i][k] - bound);
        if ((dj >= 0) != (di >= 0)) {
          Vec2 p = loop[j] + (loop[i] - loop[j]) * (dj / (dj - di));
          p[k] = bound;
          kept.push_back(p);
        }
        if (di >= 0) kept.push_back(loop[i]);
      }
      loop = std::move(kept);
    }
    if (loop.size() >= 3)
      result.push_back(std::move(loop));
    else if (result.empty())
      return {};  // without the outer loop there are no holes either
  }
  return result;
}

}  // namespace terrazzo::section

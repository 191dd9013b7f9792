#include "nodes/common/geometry/mesh/loop_moments.h"

#include <algorithm>
#include <cmath>

namespace terrazzo {

LoopMoments loop_moments(const Loop& p) {
  LoopMoments m;
  Vec2 first = Vec2::Zero();
  const Vec2 o = p[0];
  double xx = 0, yy = 0, xy = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec2 a = p[i] - o, b = p[(i + 1) % p.size()] - o;
    const double c = cross(a, b) / 2;
    m.area += c;
    first += c * (a + b) / 3;
    xx += c / 6 * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
    yy += c / 6 * (a.y() * a.y() + a.y() * b.y() + b.y() * b.y());
    xy += c / 6 * (a.x() * b.y() / 2 + b.x() * a.y() / 2 + a.x() * a.y() + b.x() * b.y());
  }
  if (!(m.area > 0)) return m;
  const Vec2 c = first / m.area;
  m.center = o + c;
  xx = xx / m.area - c.x() * c.x();
  yy = yy / m.area - c.y() * c.y();
  xy = xy / m.area - c.x() * c.y();
  const double middle = (xx + yy) / 2, spread = std::hypot((xx - yy) / 2, xy);
  m.longer = middle + spread;
  m.shorter = std::max(0.0, middle - spread);
  m.angle = std::atan2(2 * xy, xx - yy) / 2;
  return m;
}

}  // namespace terrazzo

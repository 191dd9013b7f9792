#include "nodes/shapes/shape_estimate/methods/arcs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "graph/diagnostic.h"

namespace terrazzo::shape_estimate {

namespace {

struct Crossing {
  double radius = -1;  // along the ray; −1: none
  std::size_t segment = 0;
  double fraction = 0;
  int count = 0;  // number of crossings of the ray
};

Crossing outermost(const Outline& o, const Vec2& center, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const std::size_t n = o.points.size();
  Crossing best;
  const auto side = [&](const Vec2& p) { return -s * (p.x() - center.x()) + c * (p.y() - center.y()); };
  double a = side(o.points[0]);
  for (std::size_t i = 0; i < n; ++i) {
    const double b = side(o.points[(i + 1) % n]);
    if ((a < 0) != (b < 0)) {
      const double f = a / (a - b);
      const Vec2 p = (1 - f) * o.points[i] + f * o.points[(i + 1) % n] - center;
      const double r = c * p.x() + s * p.y();
      if (r > 0) {
        ++best.count;
        if (r > best.radius) {
          best.radius = r;
          best.segment = i;
          best.fraction = f;
        }
      }
    }
    a = b;
  }
  return best;
}

}  // namespace

void Arc::parametrize() {
  t.assign(points.size(), 0);
  for (std::size_t i = 1; i < points.size(); ++i) t[i] = t[i - 1] + (points[i] - points[i - 1]).norm();
  const double total = t.back();
  for (auto& v : t) v = total > 0 ? v / total : 0;
  t.back() = 1;
}

void Arc::scale(double x, double y) {
  for (auto& p : points) p = {p.x() * x, p.y() * y};
}

void Arc::reverse() {
  std::reverse(points.begin(), points.end());
  std::reverse(corner.begin(), corner.end());
}

Vec2 Arc::at(double s) const {
  if (s <= 0) return points.front();
  if (s >= 1) return points.back();
  const std::size_t i = std::upper_bound(t.begin(), t.end(), s) - t.begin();
  const double f = (s - t[i - 1]) / (t[i] - t[i - 1]);
  return (1 - f) * points[i - 1] + f * points[i];
}

double Arc::corner_at(double s, double within) const {
  double best = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::abs(t[i] - s) <= within && std::abs(corner[i]) > std::abs(best)) best = corner[i];
  return best;
}

std::vector<Arc> cut(const Outline& o, const Vec2& center, const std::vector<double>& angles) {
  const std::size_t n = o.points.size();
  std::vector<Crossing> at;
  for (const double angle : angles) {
    at.push_back(outermost(o, center, angle));
    if (at.back().radius <= 0)
      throw Error("no-crossing",
                  "the outline of profile " + std::to_string(o.id) + " does not enclose its center",
                  "choose another profile");
  }
  std::vector<Arc> arcs(angles.size());
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const Crossing &from = at[k], &to = at[(k + 1) % angles.size()];
    const auto point = [&](const Crossing& c, double angle) {
      return Vec2(c.radius * std::cos(angle), c.radius * std::sin(angle));
    };
    Arc& arc = arcs[k];
    arc.points.push_back(point(from, angles[k]));
    arc.corner.push_back(0);
    const bool same = from.segment == to.segment && from.fraction < to.fraction;
    if (!same)
      for (std::size_t i = (from.segment + 1) % n;; i = (i + 1) % n) {
        arc.points.push_back(o.points[i] - center);
        arc.corner.push_back(o.corner[i]);
        if (i == to.segment) break;
      }
    arc.points.push_back(point(to, angles[(k + 1) % angles.size()]));
    arc.corner.push_back(0);
    arc.parametrize();
  }
  return arcs;
}

Vec2 cut_center(const Outline& o, const std::vector<double>& angles) {
  // Crossings close to the center would distort their region when it is scaled.
  const double near = 0.1 * std::sqrt(o.area);
  const auto extra = [&](const Vec2& c) {
    int count = 0;
    for (const double angle : angles) {
      const auto x = outermost(o, c, angle);
      if (x.count % 2 == 0) return std::numeric_limits<int>::max();  // outside
      count += x.count - 1 + (x.radius < near ? 2 : 0);
    }
    return count;
  };
  Vec2 best = Vec2::Zero();
  int fewest = extra(best);
  if (fewest == 0) return best;
  constexpr int kGrid = 33;
  Vec2 low = o.points[0], high = low;
  for (const auto& p : o.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  double nearest = std::numeric_limits<double>::infinity();
  if (fewest < std::numeric_limits<int>::max()) nearest = 0;
  for (int i = 1; i < kGrid; ++i)
    for (int j = 1; j < kGrid; ++j) {
      const Vec2 c = low + (high - low).cwiseProduct(Vec2(i, j) / kGrid);
      const int count = extra(c);
      if (count < fewest || (count == fewest && c.norm() < nearest)) {
        best = c;
        fewest = count;
        nearest = c.norm();
      }
    }
  return best;
}

std::vector<double> knots(const Arc& arc, int spans) {
  std::vector<double> k(spans + 1);
  for (int i = 0; i <= spans; ++i) k[i] = static_cast<double>(i) / spans;
  std::vector<std::size_t> order;
  for (std::size_t i = 1; i + 1 < arc.points.size(); ++i)
    if (arc.corner[i] != 0) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) {
    return std::abs(arc.corner[a]) > std::abs(arc.corner[b]) ||
           (std::abs(arc.corner[a]) == std::abs(arc.corner[b]) && a < b);
  });
  std::vector<int> held{0, spans};  // indices of knots that stay
  for (const auto i : order) {
    const double t = arc.t[i];
    int best = -1;
    for (int j = 1; j < spans; ++j) {
      if (std::find(held.begin(), held.end(), j) != held.end()) continue;
      // There must be room for every knot between j and its fixed neighbors.
      const auto above = std::upper_bound(held.begin(), held.end(), j);
      const double room = 0.3 / spans;
      if (t - k[*(above - 1)] < room * (j - *(above - 1)) || k[*above] - t < room * (*above - j)) continue;
      if (best < 0 || std::abs(k[j] - t) < std::abs(k[best] - t)) best = j;
    }
    if (best < 0) continue;
    k[best] = t;
    held.insert(std::upper_bound(held.begin(), held.end(), best), best);
    for (std::size_t h = 0; h + 1 < held.size(); ++h)
      for (int j = held[h] + 1; j < held[h + 1]; ++j)
        k[j] = k[held[h]] + (k[held[h + 1]] - k[held[h]]) * (j - held[h]) / (held[h + 1] - held[h]);
  }
  return k;
}

}  // namespace terrazzo::shape_estimate

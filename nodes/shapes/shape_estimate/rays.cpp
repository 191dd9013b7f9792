#include "nodes/shapes/shape_estimate/rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/data/indices.h"

namespace terrazzo::shape_estimate {

void raise_radii(std::vector<double>& radii, const Vec2& a, const Vec2& b) {
  const int rays = count_of(radii);
  const double step = 2 * std::numbers::pi / rays;
  const double from = std::atan2(a.y(), a.x());
  const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  const double low = std::min(from, from + turn);
  const double high = std::max(from, from + turn);
  const Vec2 d = b - a;
  for (int k = round_up(low / step); k * step <= high; ++k) {
    const Vec2 ray(std::cos(k * step), std::sin(k * step));
    const double across = d.x() * ray.y() - d.y() * ray.x();
    const double t = std::abs(across) > 0 ? (a.y() * ray.x() - a.x() * ray.y()) / across : 0;
    const double r = (a + std::clamp(t, 0.0, 1.0) * d).dot(ray);
    double& most = radii[((k % rays) + rays) % rays];
    most = std::max(most, r);
  }
}

Loop loop_of_radii(const std::vector<double>& radii) {
  const double step = 2 * std::numbers::pi / radii.size();
  Loop loop;
  for (int k = 0; k < count_of(radii); ++k)
    loop.push_back(radii[k] * Vec2(std::cos(k * step), std::sin(k * step)));
  return loop;
}

}  // namespace terrazzo::shape_estimate

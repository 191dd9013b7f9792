#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/shapes/shape_estimate/methods/extrusions.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/silhouettes.h"

namespace terrazzo::shape_estimate {

namespace {

constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

Polygon fitted(const Outline& o, double width, double height, bool swap) {
  Vec2 low = o.points[0], high = low;
  for (const auto& p : o.points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vec2 scale = Vec2(width, height).cwiseQuotient(high - low);
  Polygon out;
  for (const auto& p : o.points) {
    const Vec2 q = (p - (low + high) / 2).cwiseProduct(scale);
    out.push_back(swap ? Vec2(q.y(), q.x()) : q);
  }
  if (swap) std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace

std::array<Polygon, 3> silhouettes_of(std::vector<Outline> profiles, int order) {
  std::stable_sort(profiles.begin(), profiles.end(),
                   [](const Outline& a, const Outline& b) { return a.aspect > b.aspect; });
  const Outline &c0 = profiles[kOrders[order % 6][0]], &c1 = profiles[kOrders[order % 6][1]],
                &c2 = profiles[kOrders[order % 6][2]];
  const double a = c0.width, b = c0.height, c = c0.width * c2.height / c2.width;
  // The paper does not define the mirror images: choose those that cut off least of each other's silhouettes.
  std::array<Polygon, 3> best;
  double least = 2;
  for (int m1 = 0; m1 < 4; ++m1)
    for (int m2 = 0; m2 < 4; ++m2) {
      const auto mirrored = [](const Outline& o, int m) {
        const Outline x = m & 1 ? o.mirrored_x() : o;
        return m & 2 ? x.mirrored_y() : x;
      };
      const std::array<Polygon, 3> p{fitted(c0, a, b, false), fitted(mirrored(c1, m1), b, c, false),
                                     fitted(mirrored(c2, m2), a, c, true)};
      const double lost = silhouette_deviation(p);
      if (lost < least) {
        least = lost;
        best = p;
      }
      if (least < 1e-3) return best;
    }
  return best;
}

double silhouette_deviation(const std::array<Polygon, 3>& p) {
  // Depths at which a line at constant value of one coordinate enters and leaves polygon `k`.
  const auto spans = [&](int k, bool first, double w) {
    std::vector<double> at;
    const Polygon& q = p[k];
    for (std::size_t i = 0; i < q.size(); ++i) {
      const Vec2 &a = q[i], &b = q[(i + 1) % q.size()];
      const double wa = first ? a.x() : a.y(), wb = first ? b.x() : b.y();
      const double ha = first ? a.y() : a.x(), hb = first ? b.y() : b.x();
      if ((wa > w) != (wb > w)) at.push_back(ha + (w - wa) / (wb - wa) * (hb - ha));
    }
    std::sort(at.begin(), at.end());
    return at;
  };
  double worst = 0;
  for (int k = 0; k < 3; ++k) {
    const Polygon& own = p[k];
    double diameter = 0;
    for (const auto& a : own)
      for (const auto& b : own) diameter = std::max(diameter, (a - b).squaredNorm());
    diameter = std::sqrt(diameter);
    // (x_k, x_k+1) is visible if some x_k+2 is inside both other polygons.
    const auto seen = [&](const Vec2& q) {
      if (!loop_contains(own, q)) return false;
      const auto one = spans((k + 1) % 3, true, q.y()), two = spans((k + 2) % 3, false, q.x());
      for (std::size_t i = 0; i + 1 < one.size(); i += 2)
        for (std::size_t j = 0; j + 1 < two.size(); j += 2)
          if (std::min(one[i + 1], two[j + 1]) > std::max(one[i], two[j])) return true;
      return false;
    };
    Vec2 inner = Vec2::Zero();
    const std::size_t step = std::max<std::size_t>(1, own.size() / 96);
    for (std::size_t i = 0; i < own.size(); i += step) {
      const Vec2 way = inner - own[i];
      double t = 2e-4;
      while (t < 1 && t * way.norm() < 0.3 * diameter && !seen(own[i] + t * way)) t *= 1.5;
      worst = std::max(worst, t * way.norm() / diameter);
    }
  }
  return worst;
}

Estimate csg(const EstimateRequest& request, const Work& work) {
  std::vector<Outline> three(
      request.chosen.begin(),
      request.chosen.begin() +
          std::min<std::ptrdiff_t>(3, static_cast<std::ptrdiff_t>(request.chosen.size())));
  auto polygons = silhouettes_of(three, request.base);
  Estimate out;
  out.deviation = silhouette_deviation(polygons);
  // Remove points that do not matter, because each creates faces.
  const double tolerance[] = {2e-2, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4};
  for (auto& p : polygons) {
    Vec2 low = p[0], high = p[0];
    for (const auto& q : p) {
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
    p = simplified(p, tolerance[std::clamp(request.subdivision, -1, 4) + 1] * (high - low).maxCoeff());
  }
  out.mesh = intersect_extrusions(polygons, work);
  if (out.mesh.triangles.empty())
    throw Error("no-intersection", "the extrusions of the three profiles do not intersect",
                "choose other profiles");
  out.smooth = false;
  return out;
}

}  // namespace terrazzo::shape_estimate

#include "nodes/packing/rigid/contact/triangle_overlap.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/mesh/mesh_distance.h"

namespace terrazzo::packing {

double triangle_penetration(const Corners& a, const Corners& b) {
  const Vec3 ea[3] = {a[1] - a[0], a[2] - a[1], a[0] - a[2]}, eb[3] = {b[1] - b[0], b[2] - b[1], b[0] - b[2]};
  const Vec3 na = ea[0].cross(ea[1]), nb = eb[0].cross(eb[1]);
  double least = 1e300;
  const double extent = std::max({ea[0].norm(), ea[1].norm(), eb[0].norm(), eb[1].norm()});  // for rounding
  // Overlap of the projections, as the shift along the axis that separates them; < 0: separated.
  const auto part = [&](const Vec3& axis, double reference) {
    const double length = axis.norm();
    if (!(length > 1e-9 * reference)) return true;
    double lo_a = 1e300, hi_a = -1e300, lo_b = 1e300, hi_b = -1e300;
    for (int k = 0; k < 3; ++k) {
      const double pa = axis.dot(a[k]), pb = axis.dot(b[k]);
      lo_a = std::min(lo_a, pa);
      hi_a = std::max(hi_a, pa);
      lo_b = std::min(lo_b, pb);
      hi_b = std::max(hi_b, pb);
    }
    const double shift = std::min(hi_a - lo_b, hi_b - lo_a) / length;
    least = std::min(least, shift);
    return shift >= -1e-12 * extent;
  };
  const double la = std::sqrt(na.norm()), lb = std::sqrt(nb.norm());
  if (!part(na, la * la) || !part(nb, lb * lb)) return -1;
  for (const Vec3& u : ea)
    for (const Vec3& v : eb)
      if (!part(u.cross(v), u.norm() * v.norm())) return -1;
  for (const Vec3& u : ea)
    if (!part(u.cross(na), u.norm() * la * la)) return -1;
  for (const Vec3& v : eb)
    if (!part(v.cross(nb), v.norm() * lb * lb)) return -1;
  return std::max(least, 0.0);
}

namespace {

// Distance of two segments (Ericson 2005, section 5.1.9).
double segment_distance(const Vec3& p1, const Vec3& q1, const Vec3& p2, const Vec3& q2) {
  const Vec3 d1 = q1 - p1, d2 = q2 - p2, r = p1 - p2;
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), f = d2.dot(r), c = d1.dot(r), b = d1.dot(d2);
  const double det = a * e - b * b;
  double s = det > 1e-14 * a * e ? std::clamp((b * f - c * e) / det, 0.0, 1.0) : 0;
  double t = e > 0 ? (b * s + f) / e : 0;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0, 1.0);
    s = a > 0 ? std::clamp((b * t - c) / a, 0.0, 1.0) : 0;
  }
  return (p1 + s * d1 - p2 - t * d2).norm();
}

}  // namespace

double triangle_distance(const Corners& a, const Corners& b) {
  double least = 1e300;
  int feature;
  for (int i = 0; i < 3; ++i) {
    least = std::min(least, (a[i] - closest_point_on_triangle(a[i], b[0], b[1], b[2], feature)).norm());
    least = std::min(least, (b[i] - closest_point_on_triangle(b[i], a[0], a[1], a[2], feature)).norm());
    for (int k = 0; k < 3; ++k)
      least = std::min(least, segment_distance(a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3]));
  }
  return least;
}

}  // namespace terrazzo::packing

#include "nodes/shapes/shape/closed_form.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace terrazzo::shape {

using std::numbers::pi;

namespace {

double beta(double a, double b) { return std::exp(std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b)); }

std::array<double, 3> rising(const Vec3& v) {
  std::array<double, 3> s{v.x(), v.y(), v.z()};
  std::sort(s.begin(), s.end());
  return s;
}

// Carlson's R_F and R_D by duplication; R_D needs z > 0. Both series are truncated below 1e-13 relative.
double carlson_rf(double x, double y, double z) {
  for (int i = 0; i < 60; ++i) {
    const double l = std::sqrt(x * y) + std::sqrt(y * z) + std::sqrt(z * x);
    x = (x + l) / 4;
    y = (y + l) / 4;
    z = (z + l) / 4;
    const double m = (x + y + z) / 3;
    if (std::max({std::abs(x - m), std::abs(y - m), std::abs(z - m)}) < 1e-4 * m) break;
  }
  const double m = (x + y + z) / 3, X = 1 - x / m, Y = 1 - y / m, Z = -X - Y;
  const double e2 = X * Y - Z * Z, e3 = X * Y * Z;
  return (1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44) / std::sqrt(m);
}

double carlson_rd(double x, double y, double z) {
  double sum = 0, factor = 1;
  for (int i = 0; i < 60; ++i) {
    const double l = std::sqrt(x * y) + std::sqrt(y * z) + std::sqrt(z * x);
    sum += factor / (std::sqrt(z) * (z + l));
    factor /= 4;
    x = (x + l) / 4;
    y = (y + l) / 4;
    z = (z + l) / 4;
    const double m = (x + y + 3 * z) / 5;
    if (std::max({std::abs(x - m), std::abs(y - m), std::abs(z - m)}) < 1e-4 * m) break;
  }
  const double m = (x + y + 3 * z) / 5, X = 1 - x / m, Y = 1 - y / m, Z = -(X + Y) / 3;
  const double e2 = X * Y - 6 * Z * Z, e3 = (3 * X * Y - 8 * Z * Z) * Z, e4 = 3 * (X * Y - Z * Z) * Z * Z;
  const double e5 = X * Y * Z * Z * Z;
  return 3 * sum +
         factor *
             (1 - 3 * e2 / 14 + e3 / 6 + 9 * e2 * e2 / 88 - 3 * e4 / 22 - 9 * e2 * e3 / 52 + 3 * e5 / 26) /
             (m * std::sqrt(m));
}

}  // namespace

double carlson_rg(double x, double y, double z) {
  std::array<double, 3> v{x, y, z};
  std::sort(v.begin(), v.end());
  x = v[0];
  y = v[1];
  z = v[2];
  // 2 R_G = z R_F − (x − z)(y − z) R_D / 3 + √(xy/z), which is stable if z is the largest.
  return (z * carlson_rf(x, y, z) - (x - z) * (y - z) * carlson_rd(x, y, z) / 3 + std::sqrt(x * y / z)) / 2;
}

ClosedForm sphere_closed_form(double d) { return {pi / 6 * d * d * d, pi * d * d, d, pi / 4 * d * d}; }

ClosedForm ellipsoid_closed_form(const Vec3& extents) {
  const auto [a, b, c] = rising(extents / 2);
  ClosedForm f;
  f.volume = 4 * pi / 3 * a * b * c;
  f.mean_caliper = 2 * carlson_rg(a * a, b * b, c * c);
  // The surface area is 4π abc R_G of the inverse squares (Carlson's form of Legendre's result).
  f.surface_area = 4 * pi * a * b * c * carlson_rg(1 / (a * a), 1 / (b * b), 1 / (c * c));
  f.max_section_area = pi * b * c;
  return f;
}

ClosedForm box_closed_form(const Vec3& extents) {
  const auto [a, b, c] = rising(extents);
  return {a * b * c, 2 * (a * b + b * c + c * a), (a + b + c) / 2, c * std::hypot(a, b)};
}

ClosedForm cylinder_closed_form(const Vec3& e) {
  ClosedForm f;
  f.volume = pi / 4 * e.x() * e.y() * e.z();
  if (e.x() == e.y()) {
    f.mean_caliper = e.z() / 2 + pi * e.x() / 4;
    f.surface_area = pi * e.x() * e.z() + pi / 2 * e.x() * e.x();
  }
  return f;
}

ClosedForm superquadric_closed_form(const Vec3& extents, double e1, double e2) {
  const Vec3 s = extents / 2;
  ClosedForm f;
  f.volume = 2 * s.prod() * e1 * e2 * beta(e1 / 2 + 1, e1) * beta(e2 / 2, e2 / 2);
  return f;
}

ClosedForm platonic_closed_form(SolidKind kind, double e) {
  // H̄ = E·θ/(4π), where E is the sum of the edges and θ the angle between the normals
  // of two neighboring faces.
  const double e2 = e * e, e3 = e2 * e, s5 = std::sqrt(5.0), s3 = std::sqrt(3.0);
  ClosedForm f;
  if (kind == SolidKind::Tetrahedron) {
    f = {e3 / (6 * std::sqrt(2.0)), s3 * e2, 6 * e * (pi - std::acos(1.0 / 3)) / (4 * pi), s3 / 4 * e2};
  } else if (kind == SolidKind::Octahedron) {
    f = {std::sqrt(2.0) / 3 * e3, 2 * s3 * e2, 12 * e * (pi - std::acos(-1.0 / 3)) / (4 * pi), e2};
  } else if (kind == SolidKind::Dodecahedron) {
    f = {(15 + 7 * s5) / 4 * e3, 3 * std::sqrt(25 + 10 * s5) * e2,
         30 * e * (pi - std::acos(-1 / s5)) / (4 * pi), std::nullopt};
  } else if (kind == SolidKind::Icosahedron) {
    f = {5 * (3 + s5) / 12 * e3, 5 * s3 * e2, 30 * e * (pi - std::acos(-s5 / 3)) / (4 * pi), std::nullopt};
  }
  return f;
}

}  // namespace terrazzo::shape

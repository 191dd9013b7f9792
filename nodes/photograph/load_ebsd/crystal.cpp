#include "nodes/photograph/load_ebsd/crystal.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace terrazzo::load_ebsd {
namespace {

using Quaternion = Eigen::Quaternionf;
using std::numbers::pi;

Quaternion turn(int fold, const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(2 * pi / fold, axis.normalized())).cast<float>();
}

// The order of the axis c, and whether two-fold axes are normal to it.
struct Axes {
  int fold;
  bool across;
};
Axes axes_of(LaueGroup group) {
  switch (group) {
    case LaueGroup::Orthorhombic:
      return {2, true};
    case LaueGroup::TetragonalLow:
      return {4, false};
    case LaueGroup::TetragonalHigh:
      return {4, true};
    case LaueGroup::TrigonalLow:
      return {3, false};
    case LaueGroup::TrigonalHigh:
      return {3, true};
    case LaueGroup::HexagonalLow:
      return {6, false};
    case LaueGroup::HexagonalHigh:
      return {6, true};
    case LaueGroup::CubicLow:
      return {2, true};
    case LaueGroup::CubicHigh:
      return {4, true};
    default:
      return {1, false};
  }
}

bool is_cubic(LaueGroup g) { return g == LaueGroup::CubicLow || g == LaueGroup::CubicHigh; }

// White where the three parts are equal, saturated at the corners.
Vec3f mixed(double red, double green, double blue) {
  const double most = std::max({red, green, blue, 1e-12});
  const auto part = [&](double v) { return static_cast<float>(std::sqrt(std::clamp(v / most, 0.0, 1.0))); };
  return {part(red), part(green), part(blue)};
}

}  // namespace

const char* name_of(LaueGroup g) {
  static constexpr const char* names[] = {"-1",  "2/m", "mmm",   "4/m", "4/mmm", "-3",
                                          "-3m", "6/m", "6/mmm", "m-3", "m-3m"};
  return names[static_cast<int>(g)];
}

std::vector<Quaternion> Symmetry::rotations() const {
  std::vector<Quaternion> generators;
  const Axes axes = axes_of(group);
  if (group == LaueGroup::Monoclinic) generators.push_back(turn(2, Eigen::Vector3d::Unit(unique_axis)));
  if (axes.fold > 1) generators.push_back(turn(axes.fold, Eigen::Vector3d::UnitZ()));
  if (axes.across) generators.push_back(turn(2, Eigen::Vector3d::UnitX()));
  if (is_cubic(group)) generators.push_back(turn(3, Eigen::Vector3d::Ones()));
  std::vector<Quaternion> all{Quaternion::Identity()};
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const auto& g : generators) {
      const Quaternion q = (all[i] * g).normalized();
      if (std::none_of(all.begin(), all.end(),
                       [&](const Quaternion& known) { return std::abs(known.dot(q)) > 0.999f; }))
        all.push_back(q);
    }
  return all;
}

Quaternion from_bunge(double phi1, double Phi, double phi2) {
  using Eigen::AngleAxisd;
  using V = Eigen::Vector3d;
  return Eigen::Quaterniond(AngleAxisd(phi1, V::UnitZ()) * AngleAxisd(Phi, V::UnitX()) *
                            AngleAxisd(phi2, V::UnitZ()))
      .cast<float>();
}

Vec3 to_bunge(const Quaternion& q) {
  const double w = q.w(), x = q.x(), y = q.y(), z = q.z();
  const double Phi = 2 * std::atan2(std::hypot(x, y), std::hypot(w, z));
  // phi1 + phi2 and phi1 − phi2; one of them is free where Phi is 0 or 180 degrees.
  const double sum = std::hypot(w, z) < 1e-6 ? 0 : 2 * std::atan2(z, w);
  const double difference = std::hypot(x, y) < 1e-6 ? sum : 2 * std::atan2(y, x);
  const auto degrees = [](double a) {
    const double d = std::fmod(a * 180 / pi, 360.0);
    return d < 0 ? d + 360 : d;
  };
  return {degrees((sum + difference) / 2), Phi * 180 / pi, degrees((sum - difference) / 2)};
}

float half_angle_cosine(const Quaternion& a, const Quaternion& b, const std::vector<Quaternion>& rotations) {
  const Quaternion d = a.conjugate() * b;
  float most = 0;
  for (const auto& s : rotations) most = std::max(most, std::abs(d.dot(s)));
  return most;
}

Quaternion closest(const Quaternion& q, const Quaternion& reference,
                   const std::vector<Quaternion>& rotations) {
  Quaternion out = q;
  float most = -1;
  for (const auto& s : rotations) {
    const Quaternion candidate = q * s;
    const float dot = candidate.dot(reference);
    if (std::abs(dot) <= most) continue;
    most = std::abs(dot);
    out = dot < 0 ? Quaternion(-candidate.coeffs()) : candidate;
  }
  return out;
}

Vec3f direction_color(const Quaternion& q, const Symmetry& symmetry) {
  const Eigen::Vector3d h = (q.conjugate() * Eigen::Vector3f::UnitZ()).cast<double>().normalized();
  if (is_cubic(symmetry.group)) {
    Eigen::Vector3d v = h.cwiseAbs();
    std::sort(v.data(), v.data() + 3);
    // Coordinates with respect to the corners [001], [101] and [111] of the standard triangle.
    return mixed(v[2] - v[1], (v[1] - v[0]) * std::numbers::sqrt2, v[0] * std::numbers::sqrt3);
  }
  Eigen::Vector3d v = h;
  if (symmetry.group == LaueGroup::Monoclinic)  // the unique axis takes the place of c
    v = Eigen::Vector3d(h[(symmetry.unique_axis + 1) % 3], h[(symmetry.unique_axis + 2) % 3],
                        h[symmetry.unique_axis]);
  Axes axes = axes_of(symmetry.group);
  if (symmetry.group == LaueGroup::Monoclinic) axes.fold = 2;
  if (v.z() < 0) v = -v;  // all Laue groups contain the inversion
  const double from_axis = std::atan2(std::hypot(v.x(), v.y()), v.z()) / (pi / 2);
  const double sector = 2 * pi / axes.fold;
  // The two-fold axes normal to c, along a among them, are mirrors with the inversion. The first mirror is
  // normal to a, which is 30 degrees off a border of the sector if c is three-fold.
  const double shift = symmetry.group == LaueGroup::TrigonalHigh ? 0.25 : 0;
  double around = std::atan2(v.y(), v.x()) / sector - shift;
  around -= std::floor(around);
  if (axes.across) around = std::min(around, 1 - around) * 2;
  // Without mirrors, both borders of the sector are the same direction: one color, and the other between.
  else
    around = 1 - std::abs(1 - 2 * around);
  return mixed(1 - from_axis, from_axis * (1 - around), from_axis * around);
}

}  // namespace terrazzo::load_ebsd

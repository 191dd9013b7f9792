#include "nodes/photograph/synthetic_photo/stone.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/common/texture/noise.h"

namespace terrazzo::synthetic_photo {

StoneFamily::StoneFamily(Random& r) {
  angular = r.uniform() < 0.6 ? 0.15 * r.uniform() : r.uniform();
  bumps = r.uniform() < 0.65 ? r.uniform(0, 0.04) : r.uniform(0.03, 0.12);
  elongation = r.uniform(1.1, 2.6);
  flat_low = r.uniform(0.25, 0.6);
  flat_high = r.uniform(0.6, 1);
  aligned = r.uniform() < 0.3;
  turn = r.uniform(0, 3.1416);
}

Stone::Stone(Random& r, const StoneFamily& family, double radius) : radius_(radius) {
  const double ratio = std::sqrt(r.uniform(1, family.elongation)),
               turn = family.aligned ? family.turn + 0.25 * r.normal() : r.uniform(0, 6.2832);
  axis_a_ = radius * ratio;
  axis_b_ = radius / ratio;
  cosine_ = std::cos(turn);
  sine_ = std::sin(turn);
  height_ = axis_b_ * r.uniform(family.flat_low, family.flat_high);
  seed_ = r.bits();
  roughness_ = r.uniform() < 0.6 ? r.uniform(0, 0.05) * radius : 0;
  rough_scale_ = std::max(3.0, radius * r.uniform(0.08, 0.5));
  reach_ = 1.45 * axis_a_ + 2;
  if (r.uniform() < family.angular) {
    const int planes = 9 + static_cast<int>(r.below(12));
    for (int i = 0; i < planes; ++i) {
      const double z = -1 + 2 * (i + r.uniform()) / planes, a = r.uniform(0, 6.2832);
      const double s = std::sqrt(std::max(0.0, 1 - z * z));
      normals_.emplace_back(s * std::cos(a), s * std::sin(a), z);
      distances_.push_back(r.uniform(0.7, 1.0));
    }
  } else {
    power_ = r.uniform(1.8, 3.2);
    dome_ = r.uniform(1.7, 3.2);
    for (std::size_t k = 0; k < wave_.size(); ++k) {
      wave_[k] = family.bumps * r.normal() / (1 + 0.6 * k);
      phase_[k] = r.uniform(0, 6.2832);
    }
  }
}

double Stone::top(double dx, double dy) const {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const double u = (cosine_ * dx + sine_ * dy) / axis_a_, v = (cosine_ * dy - sine_ * dx) / axis_b_;
  double z = 0;
  if (!normals_.empty()) {
    double upper = 1.0, lower = -1.0;
    for (std::size_t i = 0; i < normals_.size(); ++i) {
      const Vec3& n = normals_[i];
      const double rest = distances_[i] - n.x() * u - n.y() * v;
      if (std::abs(n.z()) < 1e-3) {
        if (rest < 0) return none;
      } else if (n.z() > 0) {
        // A soft minimum wears the edges.
        const double h = rest / n.z(), d = std::abs(upper - h), k = 0.08;
        upper = std::min(upper, h) - (d < k ? (k - d) * (k - d) / (4 * k) : 0);
      } else {
        lower = std::max(lower, rest / n.z());
      }
    }
    if (upper <= lower || u * u + v * v > 1.9) return none;
    z = upper;
  } else {
    const double angle = std::atan2(v, u);
    double edge = 1;
    for (std::size_t k = 0; k < wave_.size(); ++k) edge += wave_[k] * std::cos((k + 2) * angle + phase_[k]);
    const double rho = std::pow(std::pow(std::abs(u), power_) + std::pow(std::abs(v), power_), 1 / power_) /
                       std::max(0.4, edge);
    if (rho >= 1) return none;
    z = std::pow(1 - std::pow(rho, dome_), 1 / dome_);
  }
  double h = z * height_;
  if (roughness_ > 0) h += roughness_ * turbulence(seed_, Vec3(dx, dy, 0) / rough_scale_, 2);
  return h;
}

}  // namespace terrazzo::synthetic_photo

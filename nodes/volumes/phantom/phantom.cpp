#include "nodes/volumes/phantom/phantom.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/noise.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::phantom {
namespace {

constexpr double kAir = -1000, kSkin = -250, kFat = -105, kMuscle = 52, kSheath = -75, kMarrow = -60,
                 kCompact = 1200;

double ramp(double lo, double hi, double v) {
  const double t = std::clamp((v - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
double bump(double at, double width, double v) {
  const double t = (v - at) / width;
  return std::exp(-t * t);
}
double mix(double a, double b, double t) { return a + t * (b - a); }

// All lengths are in mm for a limb 240 mm long; s runs from 0, the cut, to 1.
class Limb {
 public:
  Limb(std::uint64_t seed, double blur) : seed_(seed), blur_(blur) {}

  // p is relative to the middle of the cut.
  double value(const Vec3& p) const {
    const double s = p.z() / 240;
    const Vec2 center(7 * std::sin(2.4 * s), 5 * std::sin(3.1 * s) - 3 * s);
    const Vec2 q(p.x() - center.x(), p.y() - center.y());
    const double r = q.norm();
    if (r > 80) return kAir;
    const double angle = std::atan2(q.y(), q.x());
    double depth = outline(s, angle, p) - r;
    if (s > 0.85) {
      // Near the end the outline closes fast, so correct the distance to the side to a distance to the
      // surface.
      const double slope = (outline(s + 0.002, angle, p) - outline(s - 0.002, angle, p)) / (0.004 * 240);
      depth /= std::sqrt(1 + slope * slope);
    }
    if (depth < -2 * blur_) return kAir;
    const double thick =
        2 + (0.25 + 0.75 * girth(s) / 68) * (6.5 + 4.5 * std::cos(angle - 1.1) +
                                             3 * terrazzo::noise(seed_ + 3, p * 0.03 + Vec3::Constant(0.5)));
    double v = mix(kAir, kSkin, inside(depth));
    v = mix(v, fat(p), inside(depth - 2));
    if (depth < thick - 2 * blur_) return v;
    v = mix(v, muscle(p), inside(depth - thick));
    bone(v, q - Vec2(6, -4), s, p, 10.5 + 9 * bump(0.52, 0.07, s) + 5 * bump(0, 0.06, s), 0.525 - s, s);
    bone(v, q - Vec2(3, -3), s, p, 8.5 + 11 * bump(0.56, 0.06, s) + 4 * bump(0.93, 0.05, s), s - 0.545, s);
    bone(v, q - Vec2(-13, 6 - 4 * s), s, p, 3.8 + 2 * bump(0.6, 0.04, s) + 2.5 * bump(0.93, 0.05, s),
         s - 0.575, s);
    return v;
  }

 private:
  // The fraction of a voxel inside a surface at this depth.
  double inside(double depth) const { return std::clamp(0.5 + depth / (2 * blur_), 0.0, 1.0); }

  static double girth(double s) {
    return mix(66, 25, ramp(0.12, 0.8, s)) + 4 * bump(0.13, 0.12, s) + 4 * bump(0.93, 0.05, s);
  }
  double outline(double s, double angle, const Vec3& p) const {
    const double wave = 1 + 0.05 * std::cos(angle - 0.5) + 0.04 * std::cos(2 * angle + 1 + 2 * s) +
                        0.05 * terrazzo::noise(seed_, p * 0.02 + Vec3::Constant(0.3));
    const double end = std::clamp((s - 0.90) / 0.075, 0.0, 1.0);
    return girth(s) * wave * std::sqrt(std::max(0.0, 1 - end * end)) - (s > 0.975 ? 5 : 0);
  }
  double fat(const Vec3& p) const { return kFat + 14 * terrazzo::noise(seed_ + 4, p * 0.15); }

  double muscle(const Vec3& p) const {
    const Vec3 sway(p.x() + 3 * terrazzo::noise(seed_ + 5, p * 0.05),
                    p.y() + 3 * terrazzo::noise(seed_ + 6, p * 0.05), p.z());
    const Cell belly = cellular(seed_ + 7, Vec3(sway.x() / 26, sway.y() / 26, sway.z() / 170));
    const double fibers = turbulence(seed_ + 8, Vec3(sway.x() * 0.25, sway.y() * 0.25, sway.z() * 0.03), 3);
    const double marbling =
        ramp(0.28, 0.5, turbulence(seed_ + 9, Vec3(p.x() * 0.11, p.y() * 0.11, p.z() * 0.03), 3));
    const double meat = kMuscle + 22 * (belly.shade - 0.5) + 16 * fibers;
    // The distance between two Voronoi neighbors' surfaces is twice the distance to their border.
    const double sheath = std::clamp((1.1 - belly.edge * 26 / 2) / 0.8, 0.0, 1.0);
    return mix(mix(meat, -60, 0.8 * marbling), kSheath, sheath);
  }

  // A bone of the given radius around q = 0, where `end` (fraction of the length) is above 0.
  void bone(double& v, const Vec2& q, double, const Vec3& p, double radius, double end, double s) const {
    if (end < -0.02) return;
    const double flare = radius / (radius + 4);
    const double cap = end * 240;  // mm from its end, which is rounded like a flattened hemisphere
    const double r = q.norm();
    double depth = radius * (1 + 0.06 * std::cos(2 * std::atan2(q.y(), q.x()) + 5 * s)) - r;
    const double round = 0.6 * radius;
    if (cap < round) {
      const double t = 1 - std::max(cap, 0.0) / round;
      depth -= radius * (1 - std::sqrt(std::max(0.0, 1 - t * t)));
    }
    depth = std::min(depth, cap);
    if (depth < -2 * blur_) return;
    const double joint = bump(0.535, 0.10, s) + bump(0.95, 0.07, s);
    const double shell = mix(3.4, 1.3, std::min(1.0, joint)) * flare * 1.3;
    v = mix(v, kCompact + 60 * terrazzo::noise(seed_ + 10, p * 0.2), inside(depth));
    const double struts = turbulence(seed_ + 11, p * 0.45, 2);
    const double spongy = mix(kMarrow, 330 + 260 * struts, std::min(1.0, joint));
    v = mix(v, spongy, inside(depth - shell));
  }

  std::uint64_t seed_;
  double blur_;
};

}  // namespace

std::vector<float> limb(const LimbOptions& choice, const Work& work) {
  const Vec3i n = choice.resolution;
  const double scale = 240 / choice.length;
  const Vec3 step = scale * choice.spacing();
  const Limb body(choice.seed, 0.6 * std::max(0.4, step.head<2>().maxCoeff()));
  const Vec3 corner(-80, -80, 0);
  std::vector<float> out(voxels_in(n));
  const std::size_t rows = static_cast<std::size_t>(n.y()) * n.z();
  work.parallel(rows, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const int y = row % n.y(), z = row / n.y();
      for (int x = 0; x < n.x(); ++x) {
        const std::size_t i = row * n.x() + x;
        const Vec3 p = corner + (Vec3(x, y, z) + Vec3::Constant(0.5)).cwiseProduct(step);
        double v = body.value(p);
        if (choice.noise > 0) v += choice.noise * Random(choice.seed, 0x4c696d62, i).normal();
        out[i] = std::clamp(std::round(v), -1024.0, 3071.0);  // the range and integers that scanners store
      }
    }
  });
  return out;
}

}  // namespace terrazzo::phantom

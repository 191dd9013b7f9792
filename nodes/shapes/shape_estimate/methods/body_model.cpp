#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/geodesic_sphere.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/shapes/shape_estimate/methods/body_family.h"
#include "nodes/shapes/shape_estimate/methods/swelling.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {

namespace {

using std::numbers::pi;

constexpr int kDegrees = 5, kHarmonics = harmonic_count(kDegrees), kPlanes = 8, kFields = Fields::kCount;
constexpr int kLevel = 4;  // subdivision level of the ball: three edges per shortest wavelength

}  // namespace

struct SwellingBall {
  Mesh mesh;
  Eigen::MatrixXd swells;  // [vertex][harmonic, then field]
  std::vector<Vec3> planes;
  explicit SwellingBall(std::uint64_t seed)
      : mesh(geodesic_sphere(kLevel)), planes(spread_directions(seed, kPlanes)) {
    const Fields fields(seed);
    swells.resize(mesh.vertices.size(), kHarmonics + kFields);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const Eigen::Index row = v;
      std::array<double, kHarmonics> h;
      harmonics(mesh.vertices[v], kDegrees, h.data());
      for (int k = 0; k < kHarmonics; ++k) swells(row, k) = h[k];
      for (int k = 0; k < kFields; ++k) swells(row, kHarmonics + k) = fields(k, mesh.vertices[v]);
    }
  }
};

namespace {

// Coordinate `k` of 6 of element `index` of a low-discrepancy sequence (Roberts 2018), 0…1.
double spread(int index, int k) {
  constexpr double kStep[] = {0.8990, 0.8083, 0.7267, 0.6534, 0.5874, 0.5281};
  return std::fmod(0.5 + kStep[k] * (index + 1), 1.0);
}

// Displacement by a plane of a point at height `d` above it: d far above, 0 far below, with a smooth
// transition of width `soft`.
double pressed(double d, double soft) {
  const double t = d / soft;
  return t > 20 ? d : t < -20 ? 0 : soft * std::log1p(std::exp(t));
}

// Bends the x axis into an arc of `turn` radians towards the direction `to` of the y–z plane, or less if the
// inner side would fold.
void bend(Mesh& mesh, double turn, double to) {
  if (std::abs(turn) < 1e-3) return;
  const double c = std::cos(to), s = std::sin(to);
  double low = 1e300, high = -1e300, inner = 0;
  for (const Vec3& v : mesh.vertices) {
    low = std::min(low, v.x());
    high = std::max(high, v.x());
    inner = std::max(inner, -(c * v.y() + s * v.z()));
  }
  const double middle = (low + high) / 2, radius = std::max((high - low) / turn, 1.1 * inner);
  for (Vec3& v : mesh.vertices) {
    const double along = (v.x() - middle) / radius, up = c * v.y() + s * v.z(),
                 across = -s * v.y() + c * v.z();
    const double reach = radius + up, y = reach * std::cos(along) - radius;
    v = {reach * std::sin(along), c * y - s * across, s * y + c * across};
  }
}

class Modeled : public BodyFamily {
 public:
  Modeled(std::shared_ptr<const SwellingBall> ball, std::uint64_t seed, int guess) : ball_(std::move(ball)) {
    const auto u = [&](int k) { return spread(guess, k); };
    const auto half = [&](int k) { return std::max(0.0, 2 * u(k) - 1); };  // zero for half of the bodies
    const double turn = u(2) > 0.5 ? 0.6 + 2 * half(2) : 0;
    long_ = 0.9 * u(0) + 0.2 * turn;  // a bend is visible only on elongated bodies
    flat_ = 0.6 * u(1);
    bend_ = {turn * std::cos(pi * u(3)), turn * std::sin(pi * u(3))};
    depth_ = u(4) > 0.5 ? 0.05 + 0.2 * half(4) : 0;
    Random r(seed, 211, static_cast<std::uint64_t>(guess));
    const double lumps = 0.02 + 0.16 * u(5);
    for (int k = 0, n = 2; n <= kDegrees; ++n)
      for (int m = 0; m < 2 * n + 1; ++m, ++k) lump_[k] = lumps * r.normal() / (n * n);
  }
  int dimensions() const override { return 2 + kHarmonics + kFields + 3 * kPlanes + 1 + 1 + 2; }
  Mesh body(const Eigen::VectorXd& x) const override {
    Mesh mesh = ball_->mesh;
    int at = 0;
    const double l = bounded(long_ + 0.4 * x[at], 2), f = bounded(flat_ + 0.4 * x[at + 1], 1.4);
    at += 2;
    Eigen::VectorXd c(kHarmonics + kFields);
    for (int k = 0, n = 2; n <= kDegrees; ++n)
      for (int m = 0; m < 2 * n + 1; ++m, ++k) c[k] = bounded(lump_[k] + 0.24 / n * x[at + k], 0.4);
    at += kHarmonics;
    for (int k = 0; k < kFields; ++k) c[kHarmonics + k] = bounded(Fields::kAmplitude[k] * x[at + k], 0.12);
    at += kFields;
    const Eigen::VectorXd swell = ball_->swells * c;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      mesh.vertices[v] *= std::exp(std::clamp(swell[v], -1.2, 1.2));
    const double soft = 0.015 * std::exp(bounded(1.2 * x[at + 3 * kPlanes], 3));
    for (int k = 0; k < kPlanes; ++k, at += 3) {
      const double depth = std::min(0.6, depth_ + 0.2 * x[at]);  // relative to the body's extent
      if (depth <= 0) continue;
      const Mat3 frame = frame_about(ball_->planes[k]);
      const Vec3 n = (frame.col(2) + bounded(0.3 * x[at + 1], 0.8) * frame.col(0) +
                      bounded(0.3 * x[at + 2], 0.8) * frame.col(1))
                         .normalized();
      double high = 0;
      for (const Vec3& p : mesh.vertices) high = std::max(high, n.dot(p));
      const double level = (1 - depth) * high;
      for (Vec3& p : mesh.vertices) p -= 0.98 * pressed(n.dot(p) - level, soft) * n;
    }
    ++at;
    const double taper = bounded(0.3 * x[at++], 0.8);
    const Vec3 stretch(std::exp(l), 1, std::exp(-f));
    for (Vec3& p : mesh.vertices) {
      const double narrower = std::exp(taper * p.x());
      p = p.cwiseProduct(stretch).cwiseProduct(Vec3(1, narrower, narrower));
    }
    const double y = bend_[0] + 0.6 * x[at], z = bend_[1] + 0.6 * x[at + 1];
    bend(mesh, bounded(std::hypot(y, z), 3.4), std::atan2(z, y));
    const double scale = std::cbrt(mesh_volume(mesh) * 3 / (4 * pi));
    if (!(scale > 0)) return {};
    for (Vec3& p : mesh.vertices) p /= scale;
    return mesh;
  }

 private:
  std::shared_ptr<const SwellingBall> ball_;
  double long_ = 0, flat_ = 0, depth_ = 0;
  std::array<double, 2> bend_{};
  std::array<double, kHarmonics> lump_{};
};

}  // namespace

std::shared_ptr<const SwellingBall> swelling_ball(std::uint64_t seed) {
  return std::make_shared<const SwellingBall>(seed);
}

std::unique_ptr<BodyFamily> modeled_bodies(std::uint64_t seed, int guess,
                                           std::shared_ptr<const SwellingBall> ball) {
  return std::make_unique<Modeled>(ball ? std::move(ball) : swelling_ball(seed), seed, guess);
}

}  // namespace terrazzo::shape_estimate

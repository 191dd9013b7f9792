#include "nodes/shapes/shape_estimate/methods/body_family.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/convex_polyhedron.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/shapes/shape_estimate/methods/refine.h"
#include "nodes/shapes/shape_estimate/methods/swelling.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {

namespace {

constexpr int kFamilyDegrees = 4, kFamilyHarmonics = harmonic_count(kFamilyDegrees);
constexpr int kLowDegrees = 3, kLowHarmonics = harmonic_count(kLowDegrees);
constexpr int kFamilyPlanes = 6, kFamilyFields = Fields::kCount;

Mat3 covariance(const Mesh& mesh) {
  Mat3 sum = Mat3::Zero();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3 s = a + b + c;
    sum += a.dot(b.cross(c)) / 120 *
           (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }
  return sum;
}

// Moves the centroid to the origin, aligns the principal axes, and scales to the volume of the unit sphere.
void normalize(Mesh& m) {
  transform(m, Mat3::Identity(), -mesh_centroid(m));
  const auto solver = eigen_axes(covariance(m));
  Mat3 axes = principal_axes(solver);
  if (axes.determinant() < 0) axes.col(2) *= -1;
  transform(m, axes.transpose() / std::cbrt(mesh_volume(m) * 3 / (4 * std::numbers::pi)), Vec3::Zero());
}

Vec3 stretch_of(double a, double b) {
  const double s1 = std::exp(bounded(0.5 * a, 1)), s2 = std::exp(bounded(0.5 * b, 1));
  return {s1, s2, 1 / (s1 * s2)};
}

class Deformed : public BodyFamily {
 public:
  Deformed(Mesh start, std::uint64_t seed)
      : body_(std::move(start)), planes_(spread_directions(seed, kFamilyPlanes)) {
    normalize(body_);
    split_edges(body_, 0.12);
    const auto soft = smoothed(body_, 6);
    const std::size_t n = body_.vertices.size();
    const Fields fields(seed);
    swells_.resize(n, kFamilyHarmonics + kFamilyFields);
    for (std::size_t v = 0; v < n; ++v) {
      smoothing_.push_back(soft[v] - body_.vertices[v]);
      double h[kFamilyHarmonics];
      const Vec3 u = body_.vertices[v].normalized();
      harmonics(u, kFamilyDegrees, h);
      const Eigen::Index row = v;
      for (int k = 0; k < kFamilyHarmonics; ++k) swells_(row, k) = h[k];
      for (int k = 0; k < kFamilyFields; ++k) swells_(row, kFamilyHarmonics + k) = fields(k, u);
    }
  }
  int dimensions() const override { return 2 + kFamilyHarmonics + kFamilyFields + kFamilyPlanes + 1; }
  Mesh body(const Eigen::VectorXd& x) const override {
    Mesh mesh = body_;
    int at = 0;
    const Vec3 stretch = stretch_of(x[0], x[1]);
    at += 2;
    Eigen::VectorXd c(kFamilyHarmonics + kFamilyFields);
    for (int k = 0, n = 2; n <= kFamilyDegrees; ++n)
      for (int m = 0; m < 2 * n + 1; ++m, ++k) c[k] = bounded(0.24 / n * x[at + k], 0.4);
    at += kFamilyHarmonics;
    for (int k = 0; k < kFamilyFields; ++k)
      c[kFamilyHarmonics + k] = bounded(Fields::kAmplitude[k] * x[at + k], 0.12);
    at += kFamilyFields;
    const double smooth = std::clamp(x[at + kFamilyPlanes], -0.25, 1.6);
    const Eigen::VectorXd swell = swells_ * c;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      Vec3& p = mesh.vertices[v];
      p += smooth * smoothing_[v];
      p *= std::exp(std::clamp(swell[v], -1.2, 1.2));
      p = p.cwiseProduct(stretch);
    }
    for (int k = 0; k < kFamilyPlanes; ++k) {
      const double depth = std::min(0.6, 0.2 * std::max(0.0, x[at + k]));  // relative to the body's extent
      if (depth == 0) continue;
      double high = 0;
      for (const Vec3& p : mesh.vertices) high = std::max(high, planes_[k].dot(p));
      const double level = (1 - depth) * high;
      for (Vec3& p : mesh.vertices) {
        const Vec3& n = planes_[k];
        p -= 0.95 * std::max(0.0, n.dot(p) - level) * n;
      }
    }
    return mesh;
  }

 private:
  Mesh body_;
  std::vector<Vec3> smoothing_;  // displacement of each vertex
  Eigen::MatrixXd swells_;       // [vertex][harmonic, then field], each with unit mean square
  std::vector<Vec3> planes_;
};

// Coordinate `k` of 3 of element `index` of a low-discrepancy sequence (Roberts 2018), 0…1.
double even(int index, int k) {
  constexpr double kStep[] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  return std::fmod(0.5 + kStep[k] * (index + 1), 1.0);
}

class Faceted : public BodyFamily {
 public:
  Faceted(std::uint64_t seed, int guess)
      : long_(0.8 * even(guess, 0)), flat_(0.8 * even(guess, 1)), fields_(seed + guess) {
    const int faces = kFewestFaces + static_cast<int>(even(guess, 2) * (kMostFaces - kFewestFaces + 1));
    // Random planes, until they enclose a body of which each is a side.
    for (std::uint64_t tries = 0;; ++tries) {
      Random r(seed, 212 + tries, static_cast<std::uint64_t>(guess));
      planes_.clear();
      for (int k = 0; k < faces; ++k) {
        const Vec3 n(r.normal(), r.normal(), r.normal());
        planes_.push_back({n.normalized(), r.uniform(0.6, 1)});
      }
      const ConvexPolyhedron p = intersect(with_bounds(planes_));
      const auto used = [](const std::vector<int>& face) { return !face.empty(); };
      const auto box = p.faces.begin() + faces;
      if (std::all_of(p.faces.begin(), box, used) && std::none_of(box, p.faces.end(), used)) break;
    }
  }
  // Planes of well-separated directions cut off a part of the body.
  Faceted(Mesh start, std::uint64_t seed) : long_(0), flat_(0), fields_(seed) {
    normalize(start);
    for (const Vec3& n : spread_directions(seed, kMostFaces)) {
      double high = 0;
      for (const Vec3& p : start.vertices) high = std::max(high, n.dot(p));
      planes_.push_back({n, 0.88 * high});
    }
  }
  int dimensions() const override {
    return 3 * static_cast<int>(planes_.size()) + 2 + kLowHarmonics + kFamilyFields + 1;
  }
  Mesh body(const Eigen::VectorXd& x) const override {
    std::vector<HalfSpace> sides;
    int at = 0;
    for (const HalfSpace& side : planes_) {
      const Mat3 frame = frame_about(side.normal);
      const Vec3 n = frame.col(2) + bounded(0.3 * x[at + 1], 1) * frame.col(0) +
                     bounded(0.3 * x[at + 2], 1) * frame.col(1);
      sides.push_back({n.normalized(), side.offset * std::exp(bounded(0.25 * x[at], 1.2))});
      at += 3;
    }
    const ConvexPolyhedron p = intersect(with_bounds(sides));
    if (p.corners.size() < 4) return {};
    Mesh mesh = triangulate(p);
    // Corners where more than three planes meet do not produce a closed mesh.
    if (mesh.vertices.size() != 2 + mesh.triangles.size() / 2 || !mesh_faults(mesh).empty()) return {};
    transform(mesh, Mat3::Identity(), -mesh_centroid(mesh));
    const double volume = mesh_volume(mesh);
    if (!(volume > 0)) return {};
    transform(mesh, Mat3::Identity() / std::cbrt(volume * 3 / (4 * std::numbers::pi)), Vec3::Zero());
    split_edges(mesh, 0.32);
    const Vec3 stretch(std::exp(bounded(long_ + 0.4 * x[at], 2)), 1,
                       std::exp(-bounded(flat_ + 0.4 * x[at + 1], 2)));
    at += 2;
    const double wear = std::clamp(0.5 * x[at + kLowHarmonics + kFamilyFields], 0.0, 1.5);
    if (wear > 0) {
      const auto soft = smoothed(mesh, 4);
      for (std::size_t v = 0; v < soft.size(); ++v) mesh.vertices[v] += wear * (soft[v] - mesh.vertices[v]);
    }
    for (Vec3& v : mesh.vertices) {
      const Vec3 u = v.normalized();
      double h[kLowHarmonics], swell = 0;
      harmonics(u, kLowDegrees, h);
      for (int k = 0; k < kLowHarmonics; ++k) swell += bounded((k < 5 ? 0.07 : 0.05) * x[at + k], 0.3) * h[k];
      for (int k = 0; k < kFamilyFields; ++k)
        if (const double t = x[at + kLowHarmonics + k]; t != 0)  // as in most finite differences
          swell += bounded(0.5 * Fields::kAmplitude[k] * t, 0.1) * fields_(k, u);
      v = v.cwiseProduct(stretch) * std::exp(std::clamp(swell, -1.0, 1.0));
    }
    return mesh;
  }

 private:
  static constexpr int kFewestFaces = 4, kMostFaces = 16;

  // Half-spaces far from the body close unbounded directions.
  static std::vector<HalfSpace> with_bounds(std::vector<HalfSpace> sides) {
    for (int k = 0; k < 6; ++k) {
      Vec3 n = Vec3::Zero();
      n[k / 2] = k % 2 ? 1 : -1;
      sides.push_back({n, 3.1 + 0.01 * k});
    }
    return sides;
  }

  double long_, flat_;
  std::vector<HalfSpace> planes_;
  Fields fields_;
};

}  // namespace

std::unique_ptr<BodyFamily> deformed_bodies(Mesh start, std::uint64_t seed) {
  return std::make_unique<Deformed>(std::move(start), seed);
}

std::unique_ptr<BodyFamily> faceted_bodies(Mesh start, std::uint64_t seed) {
  return std::make_unique<Faceted>(std::move(start), seed);
}

std::unique_ptr<BodyFamily> faceted_bodies(std::uint64_t seed, int guess) {
  return std::make_unique<Faceted>(seed, guess);
}

}  // namespace terrazzo::shape_estimate

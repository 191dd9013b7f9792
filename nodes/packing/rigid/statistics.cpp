#include "nodes/packing/rigid/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/principal_axes.h"
#include "nodes/common/geometry/periodic.h"

namespace terrazzo::packing {

namespace {

template <class Which>
double fraction_of(const Shapes& shapes, const Particles& particles, Which&& which) {
  double v = 0;
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (which(i)) v += shapes.shapes[particles.shape[i]].volume * std::pow(particles.scale[i], 3);
  return v / particles.box.prod();
}

}  // namespace

double volume_fraction(const Shapes& shapes, const Particles& particles) {
  return fraction_of(shapes, particles, [](std::size_t) { return true; });
}

double void_fraction(const Shapes& shapes, const Particles& particles) {
  return fraction_of(shapes, particles, [&](std::size_t i) { return particles.is_void(i); });
}

std::pair<double, double> height_range(const Shapes& shapes, const Particles& particles, std::size_t i) {
  const Mat3 turn = particles.orientation[i].normalized().toRotationMatrix();
  const Vec3 up = particles.scale[i] * turn.row(2).transpose();
  double low = 1e300, high = -1e300;
  for (const Vec3& v : shapes.shapes[particles.shape[i]].mesh.vertices) {
    const double z = particles.position[i].z() + up.dot(v);
    low = std::min(low, z);
    high = std::max(high, z);
  }
  return {low, high};
}

namespace {

// Direction of the largest spread of the surface.
Vec3 longest_axis(const Mesh& mesh) {
  Mat3 spread = Mat3::Zero();
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double area = (b - a).cross(c - a).norm();
    const Vec3 m = (a + b + c) / 3;
    spread += area * m * m.transpose();
  }
  return eigen_axes(spread).eigenvectors().col(2);
}

}  // namespace

double nematic_order(const Shapes& shapes, const Particles& particles) {
  if (particles.count() == 0) return 0;
  std::vector<Vec3> axis;
  for (const auto& s : shapes.shapes) axis.push_back(longest_axis(s.mesh));
  Mat3 q = Mat3::Zero();
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const Vec3 u = particles.orientation[i] * axis[particles.shape[i]];
    q += 1.5 * u * u.transpose() - 0.5 * Mat3::Identity();
  }
  q /= static_cast<double>(particles.count());
  return eigen_axes(q).eigenvalues()[2];
}

Vec3 sections_per_area(const Shapes& shapes, const Particles& particles, const Work& work) {
  const Vec3 sum = work.reduce<Vec3>(
      particles.count(), 256, Vec3::Zero(),
      [&](std::size_t begin, std::size_t end) {
        Vec3 extents = Vec3::Zero();
        for (std::size_t i = begin; i < end; ++i) {
          const Mat3 turn = particles.orientation[i].toRotationMatrix();
          Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
          for (const auto& v : shapes.shapes[particles.shape[i]].mesh.vertices) {
            const Vec3 p = turn * v;
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
          }
          extents += particles.scale[i] * (high - low);
        }
        return extents;
      },
      [](const Vec3& x, const Vec3& y) { return Vec3(x + y); });
  return sum / particles.box.prod();
}

Table pair_correlation(const Particles& particles, int bins, const Work& work) {
  Table table;
  table.columns = {"r mm", "g"};
  const std::size_t n = particles.count();
  if (n < 2) return table;
  constexpr std::size_t kMost = 20000;
  const std::size_t stride = 1 + (n - 1) / kMost, looked = (n + stride - 1) / stride;
  const double per_particle = particles.box.prod() / n;
  const double farthest = std::min(0.5 * particles.box.minCoeff(), 5 * std::cbrt(per_particle));
  // A grid with cells as wide as the mean spacing; only cells within reach are visited.
  const PeriodicCells cells(particles.box, std::cbrt(per_particle), 256);
  // Centers are sorted by cell, so that consecutive centers visit the same neighbors.
  std::vector<std::int32_t> begin_of(cells.count() + 1, 0);
  for (const Vec3& p : particles.position) ++begin_of[cells.at(p) + 1];
  for (std::size_t c = 1; c < begin_of.size(); ++c) begin_of[c] += begin_of[c - 1];
  std::vector<Vec3> center(n);
  std::vector<std::int32_t> next(begin_of.begin(), begin_of.end() - 1);
  for (const Vec3& p : particles.position) center[next[cells.at(p)]++] = p;
  using Counts = std::vector<std::int64_t>;
  const Counts count = work.reduce<Counts>(
      looked, 64, Counts(bins, 0),
      [&](std::size_t begin, std::size_t end) {
        Counts part(bins, 0);
        for (std::size_t m = begin; m < end; ++m) {
          const std::size_t i = m * stride;
          const Vec3& p = center[i];
          cells.visit(p, farthest, [&](std::size_t cell) {
            for (std::size_t j = begin_of[cell]; j < static_cast<std::size_t>(begin_of[cell + 1]); ++j) {
              if (j == i) continue;
              const double distance = nearest_image(center[j] - p, particles.box).norm();
              const int bin = distance / farthest * bins;
              if (bin < bins) ++part[bin];
            }
          });
        }
        return part;
      },
      [](Counts x, const Counts& y) {
        for (std::size_t k = 0; k < x.size(); ++k) x[k] += y[k];
        return x;
      });
  for (int k = 0; k < bins; ++k) {
    const double lo = farthest * k / bins, hi = farthest * (k + 1) / bins;
    const double shell = 4.0 / 3 * std::numbers::pi * (hi * hi * hi - lo * lo * lo);
    table.rows.push_back({0.5 * (lo + hi), static_cast<double>(count[k]) / (looked * shell / per_particle)});
  }
  return table;
}

Table size_table(const SizeDistribution& d, const std::vector<double>& expected,
                 const std::vector<int>& size_class, const Vec3& box) {
  Table table;
  table.columns = {"size_low mm", "size_high mm",        "requested",
                   "achieved",    "N_V_requested 1/mm³", "N_V_achieved 1/mm³"};
  std::vector<double> achieved(d.classes(), 0);
  for (int k : size_class) ++achieved[k];
  for (std::size_t k = 0; k < d.classes(); ++k)
    table.rows.push_back({d.class_edges[k], d.class_edges[k + 1], expected[k], achieved[k],
                          expected[k] / box.prod(), achieved[k] / box.prod()});
  return table;
}

}  // namespace terrazzo::packing

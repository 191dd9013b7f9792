#include "nodes/anneal/statistics.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/anneal/neighbours.h"

namespace terrazzo::anneal {

double volume_fraction(const Shapes& shapes, const Particles& particles) {
  double v = 0;
  for (std::size_t i = 0; i < particles.count(); ++i)
    v += shapes.shapes[particles.shape[i]].volume * std::pow(particles.scale[i], 3);
  return v / particles.box.prod();
}

namespace {

// Direction in which the vertices spread most, weighted by the area around them.
Vec3 longest_axis(const Mesh& mesh) {
  Mat3 spread = Mat3::Zero();
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double area = (b - a).cross(c - a).norm();
    const Vec3 m = (a + b + c) / 3;
    spread += area * m * m.transpose();
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors().col(2);
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
  return Eigen::SelfAdjointEigenSolver<Mat3>(q).eigenvalues()[2];
}

Table pair_correlation(const Particles& particles, int bins, const Work& work) {
  Table table;
  table.columns = {"r mm", "g"};
  const std::size_t n = particles.count();
  if (n < 2) return table;
  // Far enough to see the order around a particle, and no more pairs than that takes.
  const double per_particle = particles.box.prod() / static_cast<double>(n);
  const double farthest = std::min(0.5 * particles.box.minCoeff(), 5 * std::cbrt(per_particle));
  const std::vector<double> radius(n, 0.5 * std::cbrt(per_particle));
  const double reach = farthest - 2 * radius[0];
  std::vector<double> count(bins, 0);
  const auto pairs = near_pairs(particles.box, particles.position, radius, std::max(reach, 0.0), work);
  for (const auto& p : pairs) {
    const double r = offset_of(p, particles.box, particles.position).norm();
    const int bin = static_cast<int>(r / farthest * bins);
    if (bin >= 0 && bin < bins) count[bin] += 2;
  }
  for (int k = 0; k < bins; ++k) {
    const double lo = farthest * k / bins, hi = farthest * (k + 1) / bins;
    const double shell = 4.0 / 3 * std::numbers::pi * (hi * hi * hi - lo * lo * lo);
    table.rows.push_back({0.5 * (lo + hi), count[k] / (static_cast<double>(n) * shell / per_particle)});
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

}  // namespace terrazzo::anneal

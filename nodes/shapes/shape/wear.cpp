#include "nodes/shapes/shape/wear.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/SparseCholesky>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/directions.h"
#include "nodes/common/geometry/mesh/vertex_normals.h"

namespace terrazzo::shape {
namespace {

// Mass (a third of the area around each vertex) and stiffness with cotangent weights. Negative weights, of
// flat obtuse triangles, could fold the surface and are left out; those of slivers are bounded.
struct Diffusion {
  Eigen::VectorXd mass;
  Eigen::SparseMatrix<double> stiffness;
};

Diffusion diffusion_of(const Mesh& mesh) {
  const Eigen::Index n = mesh.vertices.size();
  Diffusion out{Eigen::VectorXd::Zero(n), Eigen::SparseMatrix<double>(n, n)};
  std::vector<Eigen::Triplet<double>> entries;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const Vec3 u = mesh.vertices[b] - mesh.vertices[a], v = mesh.vertices[c] - mesh.vertices[a];
      const double twice_area = std::max(u.cross(v).norm(), 1e-300);
      out.mass[a] += twice_area / 6;
      const double w = std::clamp(u.dot(v) / twice_area, 0.0, 1e3) / 2;
      entries.insert(entries.end(), {{b, b, w}, {c, c, w}, {b, c, -w}, {c, b, -w}});
    }
  out.stiffness.setFromTriplets(entries.begin(), entries.end());
  return out;
}

}  // namespace

void round_edges(Mesh& mesh, double radius, const Work& work) {
  constexpr int kSteps = 4;  // implicit; together they are nearly a Gaussian
  // A right-angled edge that is blurred by a Gaussian has a radius of √(π/2) of its standard deviation.
  const double variance = radius * radius * 2 / std::numbers::pi;
  const Diffusion d = diffusion_of(mesh);
  Eigen::SparseMatrix<double> system = d.stiffness * (variance / 2 / kSteps);
  system.diagonal() += d.mass;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(system);
  if (solver.info() != Eigen::Success)
    throw Error("bad-wear", "the edges of a stone cannot be worn, because its triangles are degenerate",
                "choose axes that are more equal, a lower detail, or wear 0")
        .parameter("wear");
  Eigen::MatrixX3d points(mesh.vertices.size(), 3);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) points.row(i) = mesh.vertices[i].transpose();
  for (int step = 0; step < kSteps; ++step) {
    work.check();
    const Eigen::MatrixX3d right = d.mass.asDiagonal() * points;
    points = solver.solve(right);
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] = points.row(i).transpose();
}

void roughen(Mesh& mesh, double sd, double diameter, Random r) {
  constexpr int kWaves = 48;
  std::array<Vec3, kWaves> wave;
  std::array<double, kWaves> phase, weight;
  double power = 0;
  for (int i = 0; i < kWaves; ++i) {
    const double length = diameter * r.uniform(0.125, 0.6);
    wave[i] = random_direction(r) * (2 * std::numbers::pi / length);
    phase[i] = r.uniform(0, 2 * std::numbers::pi);
    weight[i] = length;
    power += length * length / 2;
  }
  const std::vector<Vec3> normals = vertex_normals(mesh);
  for (std::size_t k = 0; k < normals.size(); ++k) {
    double f = 0;
    for (int i = 0; i < kWaves; ++i) f += weight[i] * std::cos(wave[i].dot(mesh.vertices[k]) + phase[i]);
    mesh.vertices[k] += sd * f / std::sqrt(power) * normals[k];
  }
}

}  // namespace terrazzo::shape

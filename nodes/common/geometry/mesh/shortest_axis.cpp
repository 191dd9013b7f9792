#include "nodes/common/geometry/mesh/shortest_axis.h"

#include "nodes/common/geometry/mesh/principal_axes.h"

namespace terrazzo {
namespace {

constexpr double kDistinct = 0.95;  // of the variance along the next longer axis

// Variance of the surface about its center, each triangle by its area at its center.
Mat3 covariance_of(const Mesh& mesh) {
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero();
  double all = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double area = (b - a).cross(c - a).norm() / 2;
    const Vec3 center = (a + b + c) / 3;
    sum += area * center;
    squares += area * center * center.transpose();
    all += area;
  }
  if (!(all > 0)) return Mat3::Identity();
  const Vec3 mean = sum / all;
  return squares / all - mean * mean.transpose();
}

}  // namespace

std::optional<Quat> shortest_axis_up(const Mesh& mesh) {
  const auto axes = eigen_axes(covariance_of(mesh));
  if (axes.eigenvalues()[0] > kDistinct * axes.eigenvalues()[1]) return {};
  const Vec3 shortest = axes.eigenvectors().col(0);
  return Quat::FromTwoVectors(shortest, Vec3::UnitZ());
}

}  // namespace terrazzo

#include "nodes/packing/rigid/contact/distance_field.h"

#include "nodes/common/geometry/mesh/aabb_tree.h"
#include "nodes/common/geometry/mesh/mesh_distance.h"
#include "nodes/data/indices.h"

namespace terrazzo::packing {

DistanceField DistanceField::of(const Mesh& mesh, int cells, const Work& work) {
  DistanceField f;
  if (!f.make_sphere(mesh) && !f.make_planes(mesh)) f.make_grid(mesh, cells, work);
  return f;
}

namespace {

// Face planes as (normal, offset), without those of triangles of zero area.
std::vector<std::pair<Vec3, double>> face_planes(const Mesh& mesh) {
  std::vector<std::pair<Vec3, double>> planes;
  planes.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const Vec3 n =
        (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    if (!(n.norm() > 0)) continue;
    planes.emplace_back(n.normalized(), n.normalized().dot(mesh.vertices[t[0]]));
  }
  return planes;
}

double largest_radius(const Mesh& mesh) {
  double r = 0;
  for (const auto& v : mesh.vertices) r = std::max(r, v.norm());
  return r;
}

}  // namespace

bool is_sphere(const Mesh& mesh) {
  const double r = largest_radius(mesh);
  for (const auto& v : mesh.vertices)
    if (v.norm() < r * (1 - 1e-4)) return false;
  for (const auto& [n, d] : face_planes(mesh))
    if (d < r * 0.985) return false;
  return true;
}

bool DistanceField::make_sphere(const Mesh& mesh) {
  if (!is_sphere(mesh)) return false;
  const double r = largest_radius(mesh);
  kind_ = Kind::Sphere;
  radius_ = r * (1 + 1e-6);
  return true;
}

bool DistanceField::make_planes(const Mesh& mesh) {
  const double r = largest_radius(mesh);
  std::vector<std::pair<Vec3, double>> distinct;
  for (const auto& [n, d] : face_planes(mesh)) {
    bool known = false;
    for (const auto& [m, e] : distinct)
      known = known || ((n - m).norm() < 1e-5 && std::abs(d - e) < 1e-5 * r);
    if (!known) distinct.emplace_back(n, d);
    if (distinct.size() > 40) return false;
  }
  for (const auto& [n, d] : distinct)
    for (const auto& v : mesh.vertices)
      if (n.dot(v) > d + 1e-5 * r) return false;
  kind_ = Kind::Planes;
  for (const auto& [n, d] : distinct) {
    nx_.push_back(n[0]);
    ny_.push_back(n[1]);
    nz_.push_back(n[2]);
    offset_.push_back(d);
  }
  return true;
}

void DistanceField::make_grid(const Mesh& mesh, int cells, const Work& work) {
  kind_ = Kind::Grid;
  Aabb box;
  for (const auto& v : mesh.vertices) box.add(v);
  const Vec3 extent = box.high - box.low;
  const double cell = std::max(std::cbrt(extent.prod()), 0.2 * extent.maxCoeff()) / cells;
  cell_ = cell;
  inverse_cell_ = 1 / cell_;
  const double pad = 2 * cell;
  pad_ = 0.99 * pad;
  for (int a = 0; a < 3; ++a) {
    origin_[a] = box.low[a] - pad;
    n_[a] = round_up((extent[a] + 2 * pad) / cell) + 1;
  }
  grid_.resize(static_cast<std::size_t>(n_[0]) * n_[1] * n_[2]);
  const MeshDistance distance(mesh);
  work.parallel(static_cast<std::size_t>(n_[2]) * n_[1], 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const int j = row % n_[1], k = row / n_[1];
      double bound = 1e300;  // the distance changes by at most one cell between adjacent samples
      for (int i = 0; i < n_[0]; ++i) {
        const Vec3 p(origin_[0] + i * cell, origin_[1] + j * cell, origin_[2] + k * cell);
        const double d = distance.signed_distance(p, bound);
        grid_[row * n_[0] + i] = d;
        bound = std::abs(d) + 1.001 * cell;
      }
    }
  });
}

void DistanceField::include(const std::vector<Vec3>& points) {
  if (kind_ != Kind::Grid) return;
  std::vector<float> lower(grid_.size(), 0);
  for (const Vec3& point : points) {
    const Vec3f p = point.cast<float>();
    const float outside = value(p.data());
    if (!(outside > 0)) continue;
    std::size_t corner = 0;
    for (int a = 2; a >= 0; --a) {
      const int c = std::clamp<int>((p[a] - origin_[a]) * inverse_cell_, 0, n_[a] - 2);
      corner = corner * n_[a] + c;
    }
    const std::size_t sy = n_[0], sz = static_cast<std::size_t>(n_[0]) * n_[1];
    for (int k = 0; k < 8; ++k) {
      float& l = lower[corner + (k & 1) + (k >> 1 & 1) * sy + (k >> 2) * sz];
      l = std::max(l, outside);
    }
  }
  for (std::size_t k = 0; k < grid_.size(); ++k) grid_[k] -= lower[k];
}

}  // namespace terrazzo::packing

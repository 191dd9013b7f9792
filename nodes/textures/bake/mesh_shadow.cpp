#include "nodes/textures/bake/mesh_shadow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/indices.h"

namespace terrazzo::bake {
namespace {

constexpr int kRays = 256;
constexpr int kGrid = 512;  // points along an edge of the texture, at most

// Directions whose density is that of the cosine to z: a Fibonacci spiral on the disk, raised to the
// hemisphere (Malley's method).
std::vector<Vec3f> sky_directions() {
  std::vector<Vec3f> out;
  constexpr double kGolden = std::numbers::pi * (3 - 2.23606797749979);
  for (int i = 0; i < kRays; ++i) {
    const double r2 = (i + 0.5) / kRays, a = kGolden * i;
    out.push_back(
        Vec3(std::sqrt(r2) * std::cos(a), std::sqrt(r2) * std::sin(a), std::sqrt(1 - r2)).cast<float>());
  }
  return out;
}

// The mesh moved and scaled to a box of edge 1 around the origin, for which rays are made.
class Shadow {
 public:
  Shadow(const Mesh& mesh, double scale)
      : scale_(scale), scene_(scene_of(mesh)), directions_(sky_directions()) {}

  // At a point of the solid in mm, on a surface with this normal.
  float open(const Vec3& mm, const Vec3& normal) const {
    constexpr double kLift = 1e-5;  // beyond the rounding of floats in a box of edge 1
    const Vec3f from = ((mm / scale_ - center_) / size_ + kLift * normal).cast<float>();
    const Vec3f n = normal.cast<float>();
    const Vec3f right = n.unitOrthogonal(), up = n.cross(right);
    int open = 0;
    for (const Vec3f& d : directions_) open += !scene_.any(from, d.x() * right + d.y() * up + d.z() * n);
    return static_cast<float>(open) / kRays;
  }

 private:
  carving::RayScene scene_of(const Mesh& mesh) {
    Eigen::AlignedBox3d box;
    for (const Vec3& v : mesh.vertices) box.extend(v);
    center_ = box.center();
    size_ = std::max(box.sizes().maxCoeff(), 1e-300);
    carving::RayScene::Triangles triangles;
    for (const Vec3& v : mesh.vertices) triangles.positions.push_back(((v - center_) / size_).cast<float>());
    for (const Triangle& t : mesh.triangles)
      triangles.indices.insert(triangles.indices.end(), t.begin(), t.end());
    return carving::RayScene({triangles}, {carving::RayScene::Instance{}});
  }

  double scale_, size_ = 1;
  Vec3 center_ = Vec3::Zero();
  carving::RayScene scene_;
  std::vector<Vec3f> directions_;
};

// A grid of points of the texture from which rays start, and what lies between them.
class SkyGrid {
 public:
  SkyGrid(const UvTexels& texels, const TexelPlaces& places, const Shadow& shadow)
      : texels_(texels),
        places_(places),
        shadow_(shadow),
        step_((texels.size + kGrid - 1) / kGrid),
        side_((texels.size + step_ - 1) / step_),
        points_(pixels_in(side_, side_)) {}

  void shoot(int row) {
    for (int i = 0; i < side_; ++i) {
      const int x = texel_of(i), y = texel_of(row);
      Point& point = points_[pixel_at(i, row, side_)];
      point.triangle = triangle(x, y);
      if (point.triangle < 0) continue;
      point.mm = place(x, y);
      point.open = ray(x, y);
    }
  }
  int rows() const { return side_; }

  // Of a texel of a triangle.
  float open(int x, int y) const {
    const TexelPlaces::Axes axes = places_.axes(triangle(x, y));
    const Vec3f mm = place(x, y);
    // Farther away, or turned by more than 30°, is another part of the mesh.
    const float reach = 2 * static_cast<float>(step_ * std::max(axes.right.norm(), axes.down.norm()));
    const double u = double(x - step_ / 2) / step_, v = double(y - step_ / 2) / step_;
    const int i = round_down(u), j = round_down(v);
    double sum = 0, weights = 0;
    for (const auto& [di, dj] : {std::pair(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
      if (i + di < 0 || j + dj < 0 || i + di >= side_ || j + dj >= side_) continue;
      const Point& point = points_[pixel_at(i + di, j + dj, side_)];
      if (point.triangle < 0 || (point.mm - mm).norm() > reach ||
          places_.axes(point.triangle).normal.dot(axes.normal) < 0.866)
        continue;
      const double weight = (di ? u - i : i + 1 - u) * (dj ? v - j : j + 1 - v);
      sum += weight * double{point.open};
      weights += weight;
    }
    return weights > 1e-3 ? static_cast<float>(sum / weights) : ray(x, y);
  }

 private:
  struct Point {
    float open = 1;
    Vec3f mm = Vec3f::Zero();
    std::int32_t triangle = -1;
  };
  // The middle texel of a cell of the grid.
  int texel_of(int i) const { return std::min(texels_.size - 1, i * step_ + step_ / 2); }
  std::int32_t triangle(int x, int y) const { return texels_.triangle[pixel_at(x, y, texels_.size)]; }
  Vec3f place(int x, int y) const { return places_.at(triangle(x, y), x, y, 0.5, 0.5).cast<float>(); }
  float ray(int x, int y) const {
    const std::int32_t t = triangle(x, y);
    return shadow_.open(places_.at(t, x, y, 0.5, 0.5), places_.axes(t).normal);
  }

  const UvTexels& texels_;
  const TexelPlaces& places_;
  const Shadow& shadow_;
  int step_, side_;  // texels from point to point; points along an edge
  std::vector<Point> points_;
};

}  // namespace

std::vector<float> open_sky(const Mesh& mesh, const UvTexels& texels, const TexelPlaces& places, double scale,
                            const Work& work) {
  const Shadow shadow(mesh, scale);
  SkyGrid sky(texels, places, shadow);
  work.part(0, 0.8).parallel(sky.rows(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) sky.shoot(static_cast<int>(row));
  });
  std::vector<float> out(texels.triangle.size(), 1.0f);
  work.part(0.8, 1).parallel(texels.size, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row)
      for (int x = 0; x < texels.size; ++x) {
        const std::size_t at = row * texels.size + x;
        if (texels.triangle[at] >= 0) out[at] = sky.open(x, static_cast<int>(row));
      }
  });
  extend_to_blanks(texels, out);
  return out;
}

}  // namespace terrazzo::bake

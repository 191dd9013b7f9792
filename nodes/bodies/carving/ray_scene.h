// Triangles and instances of triangle meshes in Embree: nearest-hit and any-hit queries.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::carving {

inline constexpr float kBeyond = 2e-6f;  // world units by which a ray moves past a hit before continuing

// Throws Error "bad-number" for coordinates that Embree cannot square: it ends the process, or never returns.
void require_moderate(const Vec3f&);

struct RayHit {
  float distance = 0;
  std::uint32_t instance = 0, triangle = 0;
  float u = 0, v = 0;  // barycentric weights of the triangle's second and third corners
};

class RayScene {
 public:
  struct Triangles {
    std::vector<Vec3f> positions;
    std::vector<std::uint32_t> indices;
  };
  struct Instance {
    std::uint32_t mesh = 0;
    Eigen::Matrix3f linear = Eigen::Matrix3f::Identity();
    Vec3f offset = Vec3f::Zero();
  };
  // Throws Error "embree" with the library's message. The tree is built on one thread, so it is always the
  // same.
  RayScene(const std::vector<Triangles>& meshes, const std::vector<Instance>& instances);
  ~RayScene();
  RayScene(RayScene&&) noexcept;

  bool nearest(const Vec3f& origin, const Vec3f& direction, RayHit&) const;
  bool any(const Vec3f& origin, const Vec3f& direction) const;
  const Eigen::AlignedBox3f& bounds() const { return bounds_; }

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
  Eigen::AlignedBox3f bounds_;
};

}  // namespace terrazzo::carving

// The voids of a packing, repeated through the carved body.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/ray_mesh.h"
#include "nodes/bodies/carving/solid.h"

namespace terrazzo::carving {

struct HollowHit {
  float at = 0;         // distance along the ray
  Vec3f face, normal;   // pointing out of the void
  bool leaves = false;  // the ray leaves a void here, so it was inside one
};

// An image of a void, whose `mesh` is the number of its shape.
struct VoidImage {
  RayScene::Instance instance;
  Eigen::Matrix3f turn;
};
// Those that may reach into a body with these bounds, in its world units. Throws the errors of check_shown,
// and Error "too-many-particles".
std::vector<VoidImage> void_images(const Voids&, const Eigen::AlignedBox3f& bounds);

class Hollows {
 public:
  // `bounds` are the body's, in world units. Throws the errors of void_images.
  Hollows(const Voids&, const Eigen::AlignedBox3f& bounds);
  bool nearest(const Vec3f& origin, const Vec3f& direction, HollowHit&) const;
  // Whether holds() can tell (Voids::holds).
  bool known() const { return static_cast<bool>(voids_.holds); }
  // Whether a point is in a hole. Not exact close to walls.
  bool holds(const Vec3f& point) const;

 private:
  std::vector<RayMesh> meshes_;
  std::vector<std::uint32_t> mesh_of_;
  std::vector<Eigen::Matrix3f> turns_;
  Voids voids_;
  float mm_per_unit_;
  Vec3f shift_;                      // mm
  std::unique_ptr<RayScene> scene_;  // null if no void reaches the body
};

}  // namespace terrazzo::carving

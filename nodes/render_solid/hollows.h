// The voids of a packing, repeated through the carved body.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nodes/render_solid/paint.h"
#include "nodes/render_solid/ray_mesh.h"
#include "nodes/render_solid/solid.h"

namespace terrazzo::render_solid {

struct HollowHit {
  float at = 0;         // distance along the ray
  Vec3f face, normal;   // pointing out of the void
  bool leaves = false;  // the ray leaves a void here, so it was inside one
};

class Hollows {
 public:
  // `bounds` are the body's, in world units. Throws the errors of check_shown, and Error
  // "too-many-particles".
  Hollows(const Voids&, const Eigen::AlignedBox3f& bounds);
  bool nearest(const Vec3f& origin, const Vec3f& direction, HollowHit&) const;

 private:
  std::vector<RayMesh> meshes_;
  std::vector<std::uint32_t> mesh_of_;
  std::vector<Eigen::Matrix3f> turns_;
  std::unique_ptr<RayScene> scene_;  // null if no void reaches the body
};

}  // namespace terrazzo::render_solid

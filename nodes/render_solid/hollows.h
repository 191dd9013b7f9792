// The voids of a packing, repeated through whatever is carved from it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nodes/render_solid/paint.h"
#include "nodes/render_solid/ray_mesh.h"
#include "nodes/render_solid/solid.h"

namespace terrazzo {

struct HollowHit {
  float at = 0;         // along the ray
  Vec3f face, normal;   // out of the void
  bool leaves = false;  // the ray comes out of a void here: it was in one
};

class Hollows {
 public:
  // `bounds` of the body, world units. Throws what check_shown throws, and Error "too-many-particles".
  Hollows(const Voids&, const Eigen::AlignedBox3f& bounds);
  bool nearest(const Vec3f& origin, const Vec3f& direction, HollowHit&) const;

 private:
  std::vector<RayMesh> meshes_;
  std::vector<std::uint32_t> mesh_of_;
  std::vector<Eigen::Matrix3f> turns_;
  std::unique_ptr<RayScene> scene_;  // null where no void reaches the body
};

}  // namespace terrazzo

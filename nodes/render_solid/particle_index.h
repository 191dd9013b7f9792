// Which particle of a periodic packing holds a point.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/render_solid/ray_scene.h"

namespace terrazzo {

// Throws Error "no-particles", "no-such-shape", "bad-number", "bad-box" where a packing cannot be shown.
void check_shown(const Particles&, const Shapes&);

class ParticleIndex {
 public:
  // Throws what check_shown throws.
  ParticleIndex(const Particles&, const Shapes&);
  // The particle, or −1 in the binder; mm. The box repeats.
  int at(const Vec3f& mm) const;

 private:
  struct Entry {
    std::int32_t particle;
    Vec3f center;  // mm, of the image that may reach into the cell
  };
  bool holds(std::int32_t particle, const Vec3f& from_center) const;

  Vec3f box_;
  Vec3i cells_;
  std::vector<std::uint32_t> first_;  // of each cell's entries, and one more
  std::vector<Entry> entries_;
  std::vector<RayScene> meshes_;
  std::vector<RayScene::Triangles> triangles_;
  std::vector<float> outer_, inner_;  // squared radii about the origin, of each particle
  std::vector<Eigen::Matrix3f> to_mesh_;
  std::vector<std::int32_t> mesh_of_;
};

}  // namespace terrazzo

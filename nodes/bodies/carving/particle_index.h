// Finds the particle of a periodic packing that contains a point.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo::carving {

// Throws Error "no-particles", "no-such-shape", "bad-number", "bad-box" if a packing cannot be shown.
void check_shown(const Particles&, const Shapes&);

class ParticleIndex {
 public:
  // Throws the errors of check_shown.
  ParticleIndex(const Particles&, const Shapes&);
  // The particle at a point in mm, or −1 in the binder. The box repeats.
  int at(const Vec3f& mm) const;

 private:
  struct Entry {
    std::int32_t particle;
    Vec3f center;  // mm, of the periodic image that may reach into the cell
  };
  // Of a shape: adds its mesh, and returns the radii of the spheres around its origin that hold all of it,
  // and that it holds.
  std::pair<double, double> add_shape(const Shape&);
  void fill_cells(const Particles&);
  void list_in_cells(std::int32_t particle, const Vec3f& at, std::vector<std::vector<Entry>>& lists) const;
  bool holds(std::int32_t particle, const Vec3f& from_center) const;

  Vec3f box_;
  Vec3i cells_;
  std::vector<std::uint32_t> first_;  // index of each cell's first entry, plus the end
  std::vector<Entry> entries_;
  std::vector<RayScene> meshes_;
  std::vector<RayScene::Triangles> triangles_;
  std::vector<float> outer_, inner_;  // squared radii around the origin, per particle
  std::vector<Eigen::Matrix3f> to_mesh_;
  std::vector<std::int32_t> mesh_of_;
};

}  // namespace terrazzo::carving

// Finds the particle of a periodic packing that contains a point.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "nodes/bodies/carving/ray_scene.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo::carving {

// Throws Error "no-particles", "no-such-shape", "bad-number", "bad-box" if a packing cannot be shown.
void check_shown(const Particles&, const Shapes&);

class ParticleIndex {
 public:
  // Throws the errors of check_shown. Keeps a reference to the shapes.
  ParticleIndex(const Particles&, const Shapes&);
  // The particle at a point in mm, or −1 in the binder. The box repeats. Throws the errors of render_mesh().
  int at(const Vec3f& mm) const;

 private:
  struct Entry {
    std::int32_t particle;
    Vec3f center;  // mm, of the periodic image that may reach into the cell
  };
  // A shape, prepared when a point near it is asked for: of a thousand grown grains, a body's surface meets a
  // third.
  struct Solid {
    explicit Solid(const Shape&);
    bool holds(const Vec3f& at) const;

    RayScene::Triangles triangles;
    RayScene rays;
    float inner = 0;  // squared radius of the sphere around the origin that the shape holds
  };
  struct Lazy {
    std::once_flag once;
    std::optional<Solid> solid;
  };
  const Solid& solid(std::int32_t shape) const;
  void fill_cells(const Particles&);
  void list_in_cells(std::int32_t particle, const Vec3f& at, std::vector<std::vector<Entry>>& lists) const;
  bool holds(std::int32_t particle, const Vec3f& from_center) const;

  Vec3f box_;
  Vec3i cells_;
  std::vector<std::uint32_t> first_;  // index of each cell's first entry, plus the end
  std::vector<Entry> entries_;
  const Shapes& shapes_;
  mutable std::vector<Lazy> solids_;  // one per shape
  std::vector<float> outer_;          // squared radius around the origin, per particle
  std::vector<Eigen::Matrix3f> to_shape_;
  std::vector<std::int32_t> shape_;
};

}  // namespace terrazzo::carving

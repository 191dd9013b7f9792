// What is lit: a surface that rays can hit, with the colour of the solid where they do. World units: the
// longest edge of the block (or packing) is 1, z is up; the lowest point stands on the floor.
#pragma once

#include <cstdint>
#include <memory>

#include "nodes/common/linear.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/render_solid/lie.h"

namespace terrazzo {

class Paint;
class ResidualField;

// Where what is carved has holes: the voids of a packing, lying as its paint does. `particles` may be null or
// without voids; both must outlive the solid.
struct Voids {
  const Particles* particles = nullptr;
  const Shapes* shapes = nullptr;
  double repeat = 1;  // periods of the longest edge in one world unit
  Lie lie;
};

struct SurfacePoint {
  Vec3f position;
  Vec3f face;    // unit normal of the surface itself
  Vec3f normal;  // unit normal for shading: rounded edges, smooth meshes
  Vec3f albedo;
  bool open = false;  // on the convex hull: nothing of the solid is above it
};

class Solid {
 public:
  virtual ~Solid() = default;
  // `sharp`: the colour as finely as it is known; for what the camera sees.
  virtual bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint&,
                       bool sharp = false) const = 0;
  virtual bool any(const Vec3f& origin, const Vec3f& direction) const = 0;
  virtual Eigen::AlignedBox3f bounds() const = 0;
};

inline constexpr double kBevel = 0.008;  // of a block's edges

// A block of one unit along its longest edge, in the proportions of the material's period. With cut > 0 that
// share of each edge is taken from the corner at (+x, −y, +z), which shows three inner faces. Edges are
// shaded as if rounded by `bevel`. The paint must outlive the solid.
std::unique_ptr<Solid> block_solid(const Paint&, double cut = 0.5, double bevel = kBevel,
                                   const Voids& voids = {});

// A body carved from the material, its longest side one unit. Throws what render_mesh throws, and with voids
// what Hollows throws.
std::unique_ptr<Solid> object_solid(const Paint&, const Shape& object, const Voids& voids = {});

// Particles in their own colours and without voids, with the fine detail of `residual` where it is not null;
// that must outlive the solid. Throws Error "no-particles", "no-such-shape", "bad-number", "bad-box".
std::unique_ptr<Solid> particle_solid(const Particles&, const Shapes&,
                                      const ResidualField* residual = nullptr);

// A block broken across: below a rough face at `level` (share of the height, `roughness` to both sides)
// particles whose middle lies under it stay whole and stand out; the others are gone and leave their sockets
// (Singh, McAllister and others 2008, figure 1b). The block is one period of the packing; `paint` tells the
// colours of all but whole particles' surfaces. Throws what particle_solid throws.
std::unique_ptr<Solid> fracture_solid(const Paint&, const Particles&, const Shapes&, double level,
                                      double roughness, std::uint64_t seed,
                                      const ResidualField* residual = nullptr);

}  // namespace terrazzo

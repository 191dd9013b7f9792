// The surface to be rendered, with the solid's color at each hit. World units: the longest edge of the block
// (or packing) is 1, z is up, and the lowest point is on the floor.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "nodes/bodies/carving/placement.h"
#include "nodes/data/linear.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/detail/residual/skins.h"

namespace terrazzo::carving {

class Paint;

// The holes of a carved body: the voids of a packing, with the same placement as its paint. `particles` may
// be null or without voids; both must outlive the solid.
struct Voids {
  const Particles* particles = nullptr;
  const Shapes* shapes = nullptr;
  double repeat = 1;  // periods of the longest edge per world unit
  Placement placement;
  // Whether a point of the material, in mm, is in a void: needed if a ray can cross the body without
  // meeting a wall. If empty, voids are closed and walls decide.
  std::function<bool(const Vec3f&)> holds = {};
};

struct SurfacePoint {
  Vec3f position;
  Vec3f face;    // unit normal of the surface itself
  Vec3f normal;  // unit normal for shading: rounded edges, smooth meshes
  Vec3f albedo;
  bool open = false;  // on the convex hull: no part of the solid is above it
};

class Solid {
 public:
  virtual ~Solid() = default;
  // `sharp` selects the finest color detail, for camera rays.
  virtual bool nearest(const Vec3f& origin, const Vec3f& direction, SurfacePoint&,
                       bool sharp = false) const = 0;
  virtual bool any(const Vec3f& origin, const Vec3f& direction) const = 0;
  virtual Eigen::AlignedBox3f bounds() const = 0;
};

inline constexpr double kBevel = 0.008;  // of a block's edges

// A block with the proportions of the material's period and 1 as its longest edge. If cut > 0, that fraction
// of each edge is cut from the corner at (+x, −y, +z), which shows three inner faces. Edges are shaded as if
// rounded by `bevel`. The paint must outlive the solid.
std::unique_ptr<Solid> block_solid(const Paint&, double cut = 0.5, double bevel = kBevel,
                                   const Voids& voids = {});

// A body carved from the material; its longest side is 1. Throws the errors of render_mesh and, with voids,
// those of Hollows.
std::unique_ptr<Solid> object_solid(const Paint&, const Shape& object, const Voids& voids = {});

// Particles in their own colors, without voids, in the skins and with the fine detail of `residual` if these
// are not null; both must outlive the solid. Throws Error "no-particles", "no-such-shape", "bad-number",
// "bad-box".
std::unique_ptr<Solid> particle_solid(const Particles&, const Shapes&,
                                      const residual::ResidualField* residual = nullptr,
                                      const residual::Skins* skins = nullptr);

// A block broken across by a rough face at `level` (fraction of the height, with an amplitude of
// `roughness`). Particles whose center is below the face stay whole and stick out; the others are removed and
// leave sockets (Jagnow, Dorsey and Rushmeier 2008, figure 1b). The block is one period of the packing.
// `paint` provides all colors except those of whole particles' surfaces. Throws the errors of particle_solid.
std::unique_ptr<Solid> fracture_solid(const Paint&, const Particles&, const Shapes&, double level,
                                      double roughness, std::uint64_t seed,
                                      const residual::ResidualField* residual = nullptr);

}  // namespace terrazzo::carving

// What is lit: a surface that rays can hit, with the colour of the solid where they do. World units: the
// longest edge of the block (or packing) is 1, z is up; the lowest point stands on the floor.
#pragma once

#include <memory>

#include "nodes/common/linear.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo {

class ColorField;

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

// A block of `repeat` periods along the longest edge. With cut > 0 that share of each edge is taken from the
// corner at
// (+x, −y, +z), which shows three inner faces. Edges are shaded as if rounded by `bevel`. Colours are those
// of the voxels just below the faces. The field must outlive the solid.
std::unique_ptr<Solid> block_solid(const ColorField&, double repeat = 1, double cut = 0.5,
                                   double bevel = 0.008);

// A body carved from the field, which is repeated as needed: `repeat` periods over the body's longest side.
// Throws what render_mesh throws.
std::unique_ptr<Solid> object_solid(const ColorField&, const Shape& object, double repeat = 1);

// Particles in their own colours. Throws Error "no-particles", "no-such-shape", "bad-number", "bad-box".
std::unique_ptr<Solid> particle_solid(const Particles&, const Shapes&);

}  // namespace terrazzo

// What colour a solid has inside: of voxels, or of the particles themselves.
#pragma once

#include <memory>

#include "nodes/common/linear.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/render_solid/lie.h"

namespace terrazzo {

class ColorField;
class ResidualField;

class Paint {
 public:
  virtual ~Paint() = default;
  // At a point in world units (the object's longest edge is 1). `face`: the surface's normal; of voxels the
  // layer just below it is meant. `sharp`: as finely as it is known.
  virtual Vec3f at(const Vec3f& point, const Vec3f& face, bool sharp) const = 0;
  // Edges of one period, the longest being 1.
  virtual Vec3f period() const = 0;
};

// Voxels; `repeat` periods of the longest edge in one world unit. The field must outlive it. Where `layer` is
// set points on faces take the voxels half a voxel below them.
std::unique_ptr<Paint> field_paint(const ColorField&, double repeat = 1, const Lie& = {}, bool layer = true);

// Particles at full resolution in their binder, repeated as their box is, with the fine detail of `residual`
// where it is not null; that must outlive the paint. Throws what particle_solid throws.
std::unique_ptr<Paint> particle_paint(const Particles&, const Shapes&, double repeat = 1, const Lie& = {},
                                      const ResidualField* residual = nullptr);

}  // namespace terrazzo

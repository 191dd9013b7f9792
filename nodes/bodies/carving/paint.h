// The color inside a solid, from voxels or from the particles themselves.
#pragma once

#include <memory>

#include "nodes/bodies/carving/placement.h"
#include "nodes/data/linear.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/detail/residual/residual_field.h"

namespace terrazzo::carving {

class ColorField;

class Paint {
 public:
  virtual ~Paint() = default;
  // Color at a point in world units (the object's longest edge is 1). `face` is the surface normal; voxel
  // colors are taken from the layer just below it. `sharp` selects the finest detail.
  virtual Vec3f at(const Vec3f& point, const Vec3f& face, bool sharp) const = 0;
  // Relative edge lengths of one period; the longest is 1.
  virtual Vec3f period() const = 0;
};

// Colors from voxels, with `repeat` periods of the longest edge per world unit. The field must outlive the
// paint. With `layer`, points on faces use the voxels half a voxel below them.
std::unique_ptr<Paint> field_paint(const ColorField&, double repeat = 1, const Placement& = {},
                                   bool layer = true);

// Colors from particles and binder at full resolution, repeated with the period of their box, with the fine
// detail of `residual` if it is not null. All arguments must outlive the paint. Throws the errors of
// particle_solid.
std::unique_ptr<Paint> particle_paint(const Particles&, const Shapes&, double repeat = 1,
                                      const Placement& = {},
                                      const residual::ResidualField* residual = nullptr);

}  // namespace terrazzo::carving

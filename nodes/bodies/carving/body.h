// The surface of a body to be carved: closed, without color.
#pragma once

#include <memory>

#include "nodes/bodies/carving/solid.h"
#include "nodes/data/shapes.h"

namespace terrazzo::carving {

class CarvedBody {
 public:
  virtual ~CarvedBody() = default;
  // Finds the first surface along the ray, its distance, and whether the ray enters or leaves there (leaves
  // if s.face · direction > 0). Sets all of `s` except the color.
  virtual bool meet(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, float& at) const = 0;
  virtual bool any(const Vec3f& origin, const Vec3f& direction) const = 0;
  virtual Eigen::AlignedBox3f bounds() const = 0;
};

// As described for block_solid and object_solid (solid.h).
std::unique_ptr<CarvedBody> block_body(const Vec3f& size, double cut, double bevel);
std::unique_ptr<CarvedBody> object_body(const Shape& object);

}  // namespace terrazzo::carving

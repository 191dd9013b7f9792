// The outline of what is carved: a closed surface without colour.
#pragma once

#include <memory>

#include "nodes/data/shapes.h"
#include "nodes/render_solid/solid.h"

namespace terrazzo {

class CarvedBody {
 public:
  virtual ~CarvedBody() = default;
  // The first surface along the ray and its distance, whether the ray comes in or goes out there
  // (s.face · direction > 0). Sets all of `s` but the colour.
  virtual bool meet(const Vec3f& origin, const Vec3f& direction, SurfacePoint& s, float& at) const = 0;
  virtual bool any(const Vec3f& origin, const Vec3f& direction) const = 0;
  virtual Eigen::AlignedBox3f bounds() const = 0;
};

// As block_solid and object_solid say (solid.h).
std::unique_ptr<CarvedBody> block_body(const Vec3f& size, double cut, double bevel);
std::unique_ptr<CarvedBody> object_body(const Shape& object);

}  // namespace terrazzo

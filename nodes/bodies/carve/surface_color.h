// The color that RenderSolid shows at a point of a body.
#pragma once

#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/solid.h"

namespace terrazzo::carve {

class SurfaceColor {
 public:
  // Both must outlive this object.
  SurfaceColor(const carving::Solid& solid, const carving::Paint& paint) : solid_(solid), paint_(paint) {}

  // Finds the surface within `reach` of p along the outward unit normal n, by the rays that RenderSolid
  // traces. Returns the color there and moves p to it. If no ray meets it, p stays and has the solid's color
  // at p. World units.
  Vec3f at(Vec3f& p, const Vec3f& n, float reach) const;

 private:
  const carving::Solid& solid_;
  const carving::Paint& paint_;
};

}  // namespace terrazzo::carve

#include "nodes/bodies/carve/surface_color.h"

namespace terrazzo::carve {

Vec3f SurfaceColor::at(Vec3f& p, const Vec3f& n, float reach) const {
  // A long way may start in another part of the body.
  for (const float from : {reach, reach / 4, reach / 16}) {
    carving::SurfacePoint s;
    if (!solid_.nearest(p + from * n, -n, s, true) || (s.position - p).norm() > reach) continue;
    p = s.position;
    return s.albedo;
  }
  return paint_.at(p, n, true);
}

}  // namespace terrazzo::carve

// Contact of two convex polyhedra: the axis of least penetration, and all points where faces meet.
#pragma once

#include "nodes/packing/rigid/contact/polytope.h"

namespace terrazzo::packing {

struct ContactPoint {
  Vec3f p;      // world directions, mm from a's center
  float depth;  // > 0
};

struct Manifold {
  static constexpr int kMost = 24;
  Vec3f normal = Vec3f::Zero();  // unit, from a to b, world
  // Largest over all axes; < 0 if the bodies overlap, otherwise a lower bound of the distance.
  float separation = 0;
  int count = 0;
  int tests = 0;  // work done, in samples of a distance field
  ContactPoint points[kMost];
};

// A placed polyhedron; `rotation` is from its own frame to the world.
struct PlacedPolytope {
  const Polytope* polytope;
  Eigen::Matrix3f rotation;
  float scale;
};

// Separating axis test over face normals and the pairs of edges that cross on the Gauss map, then
// clipping of the incident face by the reference face (Gregorius 2013), so that faces resting on each
// other touch at all their common corners. Points closer than `margin` are included. `hint` is the axis
// from the last call for this pair, initially zero; if it still separates the bodies by more than the
// margin, nothing else is tested.
void find_manifold(const PlacedPolytope& a, const PlacedPolytope& b, const Vec3f& offset, float margin,
                   Vec3f& hint, Manifold& out);

}  // namespace terrazzo::packing

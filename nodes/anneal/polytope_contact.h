// Contact of two convex polyhedra: the axis of least penetration and all points where faces meet.
#pragma once

#include "nodes/anneal/polytope.h"

namespace terrazzo::anneal {

struct ContactPoint {
  Vec3f p;      // world directions, mm from a's centre
  float depth;  // > 0
};

struct Manifold {
  static constexpr int kMost = 24;
  Vec3f normal = Vec3f::Zero();  // unit, from a to b, world
  float separation =
      0;  // largest over all axes; < 0 where the bodies overlap, else a lower bound of the distance
  int count = 0;
  ContactPoint points[kMost];
};

// A polyhedron at a place; rotation from its own frame to the world.
struct PlacedPolytope {
  const Polytope* polytope;
  Eigen::Matrix3f rotation;
  float scale;
};

// The separating axis test over face normals and those pairs of edges that meet on the Gauss map, then the
// incident face clipped by the reference face (Gregorius 2013), so that faces that lie on each other touch in
// all their common corners. Points deeper than −margin count. `hint` is an axis of the last call for this
// pair, zero at first: where it still separates by more than the margin, nothing else is tried.
void find_manifold(const PlacedPolytope& a, const PlacedPolytope& b, const Vec3f& offset, float margin,
                   Vec3f& hint, Manifold& out);

}  // namespace terrazzo::anneal

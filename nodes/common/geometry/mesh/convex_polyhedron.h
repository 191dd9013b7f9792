// Convex polyhedra as intersections of half-spaces.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

struct HalfSpace {
  Vec3 normal;    // unit vector, outwards
  double offset;  // {x : normal·x ≤ offset}
};

// Corners and faces of an intersection of half-spaces in general position (three planes per corner).
struct ConvexPolyhedron {
  std::vector<Vec3> corners;
  // Per half-space: its corners, counterclockwise seen from outside; may be empty.
  std::vector<std::vector<int>> faces;
  double shortest_edge() const;  // 0 if there are no edges
};

// The caller must close unbounded directions with additional half-spaces. O(n⁴), for small n.
ConvexPolyhedron intersect(const std::vector<HalfSpace>&);

// Each face becomes a fan around its midpoint.
Mesh triangulate(const ConvexPolyhedron&);

}  // namespace terrazzo

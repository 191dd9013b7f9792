// Convex polyhedra as intersections of half-spaces.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

struct HalfSpace {
  Vec3 normal;    // unit, outwards
  double offset;  // {x : normal·x ≤ offset}
};

// Corners and faces of an intersection of half-spaces in general position (three planes meet in a corner).
struct ConvexPolyhedron {
  std::vector<Vec3> corners;
  std::vector<std::vector<int>>
      faces;  // of each half-space: its corners counter-clockwise from outside; may be empty
  double shortest_edge() const;  // 0 where there is none
};

// Unbounded directions must be closed by the caller's own half-spaces. O(n⁴) of small n.
ConvexPolyhedron intersect(const std::vector<HalfSpace>&);

// Each face as a fan about its middle.
Mesh triangulate(const ConvexPolyhedron&);

}  // namespace terrazzo

// Convex polyhedra given by their corners and faces.
#pragma once

#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::tessellation {

struct Face {
  int neighbor = -1;         // seed beyond the face
  double area = 0;           // mm²
  Vec3 normal;               // outward unit vector
  std::vector<int> corners;  // counterclockwise seen from outside
};

struct ConvexCell {
  double volume = 0;             // mm³
  Vec3 centroid = Vec3::Zero();  // mm, relative to the seed
  std::vector<Vec3> corners;     // mm, relative to the seed
  std::vector<Face> faces;
};

struct Plane {
  Vec3 normal;        // outward unit vector
  double offset = 0;  // mm: the cell is {x : normal·x ≤ offset}
  int neighbor = -1;
};

// The planes of the cell's faces.
std::vector<Plane> planes_of(const ConvexCell& cell);

// The cell between planes, inside a cube of edge 2·`reach` (mm) about the origin, whose faces have neighbor
// −1. Without corners if nothing is left.
ConvexCell cell_between(const std::vector<Plane>& planes, double reach);

}  // namespace terrazzo::tessellation

// Shapes: particle shapes as watertight triangle meshes with probabilities.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/linear.h"
#include "nodes/data/size_trend.h"
#include "runtime/value.h"

namespace terrazzo {

using Triangle = std::array<std::int32_t, 3>;
using CornerUv = std::array<Eigen::Vector2f, 3>;

struct Mesh {
  std::vector<Vec3> vertices;       // mm
  std::vector<Triangle> triangles;  // counterclockwise seen from outside
};

// The photographed stone whose silhouette from above, along −z, a shape has.
struct TracedStone {
  std::int32_t profile = 0;    // its number in Labels, from 1; 0: the shape was not traced
  Vec2 origin = Vec2::Zero();  // of the mesh in the photograph, mm from the section's lower left corner
  double turn = 0;             // radians, counterclockwise, of the photograph's stone relative to the mesh
  bool faceted = false;        // the mesh has flat faces, but not those of the photographed stone
};

// A mesh with its measures at scale 1, computed by `measure_shape`
// (nodes/common/stereology/shape_measures.h).
struct Shape {
  std::string name;
  double probability = 1;       // by number; the probabilities of a set sum to 1
  SizeTrend trend;              // of the probability
  int cls = -1;                 // color or particle class whose particles have this shape; −1: any
  Mesh mesh;                    // centroid at the origin
  double volume = 0;            // mm³
  double surface_area = 0;      // mm²
  double mean_caliper = 0;      // mm; mean distance of parallel tangent planes over all directions
  double max_section_area = 0;  // mm², maximum over all planes
  bool smooth = false;          // render with interpolated normals
  std::vector<Vec3f> color;     // of each vertex, scene-linear; empty: none
  // Of each triangle's corners in a texture whose upper left corner is (0, 0) and lower right (1, 1); empty:
  // none.
  std::vector<CornerUv> uv;
  TracedStone traced;

  // A particle's size in mm: √(4·A_max/π), the diameter of a sphere.
  double size() const;
};

struct Shapes {
  std::vector<Shape> shapes;
};

template <>
const ValueType& value_type<Shapes>();

}  // namespace terrazzo

// Shapes: the particles' forms, watertight triangle meshes with probabilities.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/value.h"

namespace terrazzo {

using Triangle = std::array<std::int32_t, 3>;

struct Mesh {
  std::vector<Vec3> vertices;       // mm
  std::vector<Triangle> triangles;  // counter-clockwise seen from outside
};

// Size and section measures of a mesh at scale 1; `measure_shape` (nodes/common/shape_measures.h) fills them.
struct Shape {
  std::string name;
  double probability = 1;       // by number; a set sums to 1
  Mesh mesh;                    // centroid at the origin
  double volume = 0;            // mm³
  double surface_area = 0;      // mm²
  double mean_caliper = 0;      // mm, mean distance of parallel tangent planes over all directions
  double max_section_area = 0;  // mm², over all planes
  bool smooth = false;          // shade with interpolated normals

  // A particle's size: √(4·A_max/π), mm; a sphere's diameter.
  double size() const;
};

struct Shapes {
  std::vector<Shape> shapes;
};

template <>
const ValueType& value_type<Shapes>();

}  // namespace terrazzo

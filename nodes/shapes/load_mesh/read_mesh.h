// Polygon meshes from files, exactly as stored: no vertices joined, nothing dropped.
#pragma once

#include <filesystem>
#include <vector>

#include "nodes/common/io/reading.h"
#include "nodes/data/linear.h"

namespace terrazzo::load_mesh {

// Only surfaces need them, so that damaged ones do not fail other loads.
enum class TextureCoordinates { Ignored, Read };

struct PolygonSoup {
  std::vector<Vec3> vertices;              // in the file's unit (glTF: mm), with all digits of the file
  std::vector<std::vector<int>> polygons;  // at least three indices each
  // Of each polygon's corners in a texture whose upper left corner is (0, 0), as glTF and OBJ files have
  // them; empty unless they are read, and all corners of all polygons have finite ones.
  std::vector<std::vector<Eigen::Vector2f>> uv;
  std::size_t without_uv = 0;  // polygons of an OBJ or glTF file that lack some, if they are read
};

// Reads OBJ, PLY, STL, OFF or glTF, selected by extension. Equal positions in an STL file become one vertex.
// Throws Error "unknown-format", "unreadable-mesh" if the file is damaged, "bad-mesh" if an index is out of
// range or a coordinate is not finite, and "too-large" if the mesh would exceed the memory budget.
// Time and memory are bounded by the file size: counts in a header allocate nothing
// until their bytes are read.
PolygonSoup read_mesh(const std::filesystem::path&, const Reading& = {},
                      TextureCoordinates = TextureCoordinates::Ignored);

}  // namespace terrazzo::load_mesh

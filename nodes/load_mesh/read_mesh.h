// Triangle and polygon meshes from files, exactly as written: nothing joined, nothing dropped.
#pragma once

#include <filesystem>
#include <vector>

#include "nodes/common/linear.h"

namespace terrazzo {

struct PolygonSoup {
  std::vector<Vec3> vertices;              // in the file's unit; single precision, as the reader gives them
  std::vector<std::vector<int>> polygons;  // three indices or more
};

// OBJ, PLY, STL or OFF, by extension, through OpenMesh's readers. STL vertices of equal position are one.
// Throws Error "unknown-format", "unreadable-mesh" (with the reader's words) or "bad-mesh" where an index
// names no vertex or a coordinate is not finite.
PolygonSoup read_mesh(const std::filesystem::path&);

}  // namespace terrazzo

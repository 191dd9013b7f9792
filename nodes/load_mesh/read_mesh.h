// Triangle and polygon meshes from files, exactly as written: nothing joined, nothing dropped.
#pragma once

#include <filesystem>
#include <vector>

#include "nodes/common/linear.h"
#include "nodes/common/reading.h"

namespace terrazzo {

struct PolygonSoup {
  std::vector<Vec3> vertices;              // in the file's unit, rounded to single precision
  std::vector<std::vector<int>> polygons;  // three indices or more
};

// Reads OBJ, PLY, STL or OFF, by extension. STL vertices of equal position are one. Throws Error
// "unknown-format", "unreadable-mesh" if the file is damaged, "bad-mesh" if an index names no vertex or a
// coordinate is not finite, and "too-large" if the mesh would exceed the budget. Time and memory are bounded
// by the size of the file: whatever a header promises, nothing is made before its bytes were read.
PolygonSoup read_mesh(const std::filesystem::path&, const Reading& = {});

}  // namespace terrazzo

// VTK unstructured grids (.vtu, VTK XML format 1.0): one hexahedron per voxel. Lengths are meters.
#pragma once

#include <filesystem>

#include "nodes/export/formats/solvers/vti_file.h"

namespace terrazzo::exporting {

// Point (i, j, k): i + (nx + 1)·(j + (ny + 1)·k). The cell data are those of the .vti file. The field data
// nodes_X0 … nodes_Z1 (Int64) are the points of the six sides with their edges and corners; opposite sides
// have the same order, so equal positions are periodic pairs. Throws Error "bad-names", "write-failed",
// "too-large".
void write_vtu(const std::filesystem::path&, const VtiContent&, std::uint64_t memory, const Work& = {});

}  // namespace terrazzo::exporting

// VTK image data (.vti, VTK XML format 1.0) for DAMASK, ParaView and FFT solvers. Written in the dialect that
// DAMASK's own reader accepts: one XML element per line, cell data in base64 on one line, the extent starting
// at 0, no rotation. Lengths are meters: 1 mm is 0.001.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/export/formats/solvers/vtk_arrays.h"
#include "nodes/export/regions.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

struct VtiContent {
  VoxelBox box;
  std::vector<VoxelSource> grids;   // cell data under the grids' names: Int32 or Float32, 1 or 3 components
  const VoxelSource* id = nullptr;  // with `regions`, adds the cell data `material` and `phase`, Int32
  const Regions* regions = nullptr;
  VtkCompression compression = VtkCompression::Zlib;
  std::string provenance;  // JSON for the field data `provenance`, or empty
};

// The field data `period` (three Int32, voxels) tells that the volume tiles. Throws Error "bad-names" if a
// grid has the name of other cell data or its name is empty or contains control characters, "write-failed".
void write_vti(const std::filesystem::path&, const VtiContent&, const Work& = {});

// For files with the same content on other meshes: the cell data; and the element FieldData, with `more`
// arrays of Int64. Throws Error "bad-names".
std::vector<VtkArray> cell_arrays(const VtiContent&);
void write_field_data(std::ostream&, const VtiContent&, const Work&, const std::vector<VtkArray>& more);

}  // namespace terrazzo::exporting

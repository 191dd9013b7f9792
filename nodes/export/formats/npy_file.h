// NumPy arrays (.npy, format version 1.0), little-endian.
#pragma once

#include <filesystem>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// An array of shape (nx, ny, nz) in Fortran order, so that a[x, y, z] is a voxel; vectors have the shape
// (nx, ny, nz, 3). Type int32 or float32. Throws Error "write-failed".
void write_npy(const std::filesystem::path&, const VoxelSource&, const VoxelBox&, const Work& = {});

// An array of shape (sections, height, width) in C order, int32, rows from the top. Throws Error
// "empty-labels", "write-failed".
void write_npy(const std::filesystem::path&, const Labels&);

}  // namespace terrazzo::exporting

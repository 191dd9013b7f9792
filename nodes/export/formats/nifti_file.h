// NIfTI-1 volumes (.nii, or .nii.gz compressed) for medical viewers and Python. Lengths in mm; x points to
// the right, y to the front and z to the head, as LoadVolume reads them.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// One grid with one number per voxel, as INT32 or FLOAT32. The grid `id` is stored plus 1, so that 0 is the
// binder, the background of label viewers. `provenance`: JSON for a comment in the header, or empty. Throws
// Error "not-a-scalar" (a grid of vectors), "too-large" (an edge above 32767 voxels), "write-failed".
void write_nifti(const std::filesystem::path&, const VoxelSource&, const VoxelBox&,
                 const std::string& provenance = {}, const Work& = {});

}  // namespace terrazzo::exporting

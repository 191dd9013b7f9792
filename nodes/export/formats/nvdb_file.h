// NanoVDB files, for renderers on a GPU.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// Without the grids that the format has no type for, whose names are appended to `lost`. It has one for
// float, double, int32, bool, vec3s and vec3d grids.
Volume fit_for_nvdb(const Volume&, std::vector<std::string>& lost);

// Writes the grids with their names, classes, transforms (mm) and inactive voxels; compressed by zlib. The
// format has no room for provenance or a period. Throws Error "no-grids", "unsupported-grid", "bad-names" (a
// name of more than 255 bytes), "write-failed".
void write_nvdb(const std::filesystem::path&, const Volume&, const Work&);

// One grid of floats `name`: the values of all voxels of the box, x fastest.
void write_nvdb(const std::filesystem::path&, const std::string& name, const VoxelBox&,
                const std::vector<float>& values, const Work&);

}  // namespace terrazzo::exporting

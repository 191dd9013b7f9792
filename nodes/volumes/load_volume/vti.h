// Reader of VTK image data (.vti, VTK XML).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "nodes/common/io/reading.h"
#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo::load_volume {

bool is_vti(const std::filesystem::path&);

// The cell data as grids of the same names: whole numbers become int32, vectors vec3s or vec3i, others float.
// With `grid` only that one. `material` and `phase`, which Export makes from `id`, are left out if there is
// an `id` and no other is named. Lengths in the file are meters; `spacing` (mm) overrides the voxels' edges.
// Field data `period` becomes the volume's resolution if it is the extent. Reads ascii, binary and appended
// data, uncompressed or compressed by zlib. Adds warnings to `reading`. Throws Error "unreadable-volume",
// "not-a-volume" (no cell data, several pieces, rotated axes), "no-such-grid", "too-large", "bad-values"
// (NaN, infinity, or beyond int32), "no-spacing".
Volume read_vti(const std::filesystem::path&, const std::string& grid, std::optional<Vec3> spacing,
                const Reading& = {}, const Work& = {});

}  // namespace terrazzo::load_volume

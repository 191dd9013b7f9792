// Reader of OpenVDB files.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/io/reading.h"
#include "nodes/data/volume.h"

namespace terrazzo::load_volume {

bool is_vdb(const std::filesystem::path&);
// Reads the grid named `grid`, or with "" all grids of supported types (float, double, vec3s, int32, bool).
// The period that Export stores becomes the volume's resolution. Validates the whole file before passing any
// of it to OpenVDB. Throws Error "unreadable-volume", "no-such-grid", "too-large", and "bad-values" if a grid
// contains NaN or infinity.
Volume read_vdb(const std::filesystem::path&, const std::string& grid, const Reading& = {});

}  // namespace terrazzo::load_volume

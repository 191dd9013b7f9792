// Reader of OpenVDB files.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/io/reading.h"
#include "nodes/data/opaque_volume.h"

namespace terrazzo::load_volume {

bool is_vdb(const std::filesystem::path&);
// Reads the grid named `grid`, or with "" all grids of supported types (float, double, vec3s, int32, bool).
// Grids of whole numbers that Export stored as floats become int32 and vec3i again, unless another program
// has given them other numbers. The period that Export stores becomes the volume's resolution. Validates the
// whole file before passing any of it to OpenVDB. Throws Error "unreadable-volume", "no-such-grid",
// "too-large", and "bad-values" if a grid contains NaN or infinity.
Volume read_vdb(const std::filesystem::path&, const std::string& grid, const Reading& = {});

// Renames grids whose names are not UTF-8, which reports and glTF files require. Returns a warning for each.
// Throws Error "unreadable-volume" if two grids then share a name.
std::vector<std::string> make_names_valid(Volume&);

}  // namespace terrazzo::load_volume

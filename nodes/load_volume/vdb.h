// OpenVDB files.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/data/volume.h"

namespace terrazzo::load_volume {

bool is_vdb(const std::filesystem::path&);
// `grid`: the name of the one that is wanted, or "" for all of known types (float, double, vec3s, int32,
// bool). The period that Export notes comes back as the volume's resolution. Throws Error
// "unreadable-volume", "no-such-grid", "bad-values" where one holds NaN or infinity.
Volume read_vdb(const std::filesystem::path&, const std::string& grid);

}  // namespace terrazzo::load_volume

// OpenVDB files.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/common/reading.h"
#include "nodes/data/volume.h"

namespace terrazzo::load_volume {

bool is_vdb(const std::filesystem::path&);
// `grid` names the one that is wanted, or is "" for all of known types (float, double, vec3s, int32, bool).
// The period that Export notes comes back as the volume's resolution. The whole file is checked before
// OpenVDB sees a byte of it. Throws Error "unreadable-volume", "no-such-grid", "too-large", and "bad-values"
// if a grid holds NaN or infinity.
Volume read_vdb(const std::filesystem::path&, const std::string& grid, const Reading& = {});

}  // namespace terrazzo::load_volume

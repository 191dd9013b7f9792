// OpenVDB files: a volume's grids unchanged, with their provenance as file metadata.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/data/opaque_volume.h"

namespace terrazzo::exporting {

// The file has the metadata "creator", "provenance" (the given JSON, if not empty) and "period" (voxels, if
// the volume is periodic). Grids keep their name, class, transform (mm) and metadata. Throws Error
// "no-grids", "write-failed".
void write_vdb(const std::filesystem::path&, const Volume&, const std::string& provenance = {});

}  // namespace terrazzo::exporting

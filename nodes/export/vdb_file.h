// OpenVDB files: a volume's grids as they are, with what made them as the file's metadata.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/data/volume.h"

namespace terrazzo {

// Metadata of the file: "creator", "provenance" (the JSON given, where not empty) and "period" (voxels, where
// the volume is periodic). Grids keep name, class, transform (mm) and their own metadata. Throws Error
// "no-grids", "write-failed".
void write_vdb(const std::filesystem::path&, const Volume&, const std::string& provenance = {});

}  // namespace terrazzo

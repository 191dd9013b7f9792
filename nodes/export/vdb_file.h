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

// The "provenance" of a file, "" where it has none or cannot be read.
std::string vdb_provenance(const std::filesystem::path&);

}  // namespace terrazzo

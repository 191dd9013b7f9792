// Provenance stored in exported files.
#pragma once

#include <filesystem>
#include <string>

namespace terrazzo {

// The JSON that Export stored in an image, .glb, .usda, .vdb, .vti, .dream3d, .ktx2, .inp or .nii file; "" if
// there is none or the file cannot be read.
std::string read_provenance(const std::filesystem::path&);

}  // namespace terrazzo

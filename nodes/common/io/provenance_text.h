// Provenance in the formats whose files are text, or begin with it, and in NIfTI. Each returns "" if there is
// none. Reads only the beginning of a file, where Export puts it.
#pragma once

#include <filesystem>
#include <string>

namespace terrazzo {

std::string provenance_in_usda(const std::filesystem::path&);   // customLayerData
std::string provenance_in_scene(const std::filesystem::path&);  // a comment; .xml (base64) or .pbrt
std::string provenance_in_inp(const std::filesystem::path&);    // comment lines
std::string provenance_in_vti(const std::filesystem::path&);    // field data, as Export encodes it
std::string provenance_in_nifti(const std::filesystem::path&);  // header extension; .nii or .nii.gz

}  // namespace terrazzo

// OpenVDB files: a volume's grids, with their provenance as file metadata.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/data/opaque_volume.h"

namespace terrazzo::exporting {

// How grids of whole numbers (int32 and vec3i, such as `id` and `source`) are stored. The values are in the
// order of the parameter's words.
enum class WholeNumbers {
  Float,  // as float and vec3s grids, which more programs read; exact up to 2^24. Each grid's metadata
          // `stored_from` names its type, by which LoadVolume makes it whole again.
  Int32,  // unchanged
};

// The file has the metadata "creator", "provenance" (the given JSON, if not empty) and "period" (voxels, if
// the volume is periodic). Grids keep their name, class, transform (mm) and metadata. Throws Error
// "no-grids", "too-many-labels" (Float, and a number beyond 2^24), "write-failed".
void write_vdb(const std::filesystem::path&, const Volume&, const std::string& provenance = {},
               WholeNumbers = WholeNumbers::Float);

}  // namespace terrazzo::exporting

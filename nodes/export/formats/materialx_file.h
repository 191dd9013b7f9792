// MaterialX: a surface whose inputs are the maps beside the file.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/export/formats/material_maps.h"

namespace terrazzo::exporting {

// In the order of the parameter's words.
enum class SurfaceShader {
  StandardSurface,  // Autodesk Standard Surface, MaterialX 1.38
  OpenPbr           // OpenPBR, MaterialX 1.39
};

// Refers to the files of kMaps beside it, of those that have an image. The shaders have no input for
// occlusion, height and ids, so these maps are left to the user. Throws Error "missing-input" without
// base_color, "write-failed".
void write_materialx(const std::filesystem::path&, const MaterialMaps&, SurfaceShader,
                     const std::string& provenance = {});

}  // namespace terrazzo::exporting

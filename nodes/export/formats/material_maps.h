// The texture maps of a material, as TextureSet makes them, in picture files and in .glb.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/shapes.h"

namespace terrazzo::exporting {

// In the order of kMaps. Null where a map is not connected.
struct MaterialMaps {
  const Image* base_color = nullptr;
  const Image* normal = nullptr;
  const Image* height = nullptr;
  const Image* roughness = nullptr;
  const Image* occlusion = nullptr;
  const Image* id = nullptr;
};

// The inputs of Export, and the names of the files that a .mtlx file refers to.
struct MapName {
  const char *name, *file, *doc;
  const Image* MaterialMaps::*image;
};
inline constexpr std::array<MapName, 6> kMaps = {{
    {"base_color", "base_color.png", "Color without light, written as sRGB", &MaterialMaps::base_color},
    {"normal", "normal.png", "Normals as (n + 1) / 2, written as they are, in .png with 16 bits",
     &MaterialMaps::normal},
    {"height", "height.exr", "Heights in mm, written as floats", &MaterialMaps::height},
    {"roughness", "roughness.png", "Roughness, written as it is in one channel", &MaterialMaps::roughness},
    {"occlusion", "occlusion.png", "Occlusion, written as it is in one channel", &MaterialMaps::occlusion},
    {"id", "id.png", "Colors of particles, written as they are", &MaterialMaps::id},
}};

// One map by its name. Values are not dithered; base_color is written as write_picture() does. Throws Error
// "format-does-not-fit" for heights in a format without floats, "bad-pixels", and the errors of
// write_samples.
void write_map(const std::filesystem::path&, const MapName&, const Image&, const std::string& provenance);

// Maps as the channels of one picture: .png with 8 bits, .tif with 16, .exr with floats, all raw. A channel
// is "roughness" (the first channel of that map), "normal.g" or "normal.b", "1-roughness" for one minus it,
// "black" or "white". Throws Error "bad-value" for other words and for base_color, which is not raw,
// "missing-input", "size-mismatch", "bad-pixels", "format-does-not-fit" for heights in a format without
// floats, and the errors of write_samples.
void write_packed_maps(const std::filesystem::path&, const MaterialMaps&,
                       const std::vector<std::string>& channels, const std::string& provenance);

// The mesh, or without one a plane of the maps' size in mm, z up, with all maps as one material. Throws Error
// "missing-input" without base_color, "size-mismatch", "no-uv", and the errors of GltfPacker::write.
void write_glb(const std::filesystem::path&, const MaterialMaps&, const std::string& provenance,
               const Shape* mesh = nullptr);

}  // namespace terrazzo::exporting

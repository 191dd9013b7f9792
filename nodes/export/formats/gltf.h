// glTF 2.0 binary: particles as instances of their shapes (EXT_mesh_gpu_instancing), or only shapes.
//
// Lengths: 1 mm is written as 0.001 m. Axes: y points up in glTF, z in Terrazzo, so every point, rotation and
// normal is rotated by −90° about x: (x, y, z) → (x, z, −y). Colors are scene-linear, like glTF's color
// factors.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// How particles are stored. The values are in the order of the parameter's words.
enum class Instancing {
  Extension,  // EXT_mesh_gpu_instancing: one node per shape, compact
  Nodes,      // one node per particle, for readers without the extension: Blender, Godot, Unreal
};

// Voids are omitted.
//
// Extension: one mesh and one node per shape in use. The node's instances have TRANSLATION, ROTATION, SCALE,
// `_COLOR_0` (three floats, scene-linear; three.js uses it as the instance color) and `_ID` (the particle's
// index as a float, exact below 2^24), in particle order. All share one white material.
//
// Nodes: one node per particle, named SHAPE_INDEX, below a node `particles`. Its extras hold `id` (the
// particle's index), `class`, `size_mm` and `color`, which is exact. The meshes of a shape share their
// buffers and differ in the material; there are at most `materials` of them (color_classes.h), so colors are
// rounded if the particles have more.
//
// `provenance` is a JSON object for asset.extras, or empty. `index`: the index to write for each particle;
// empty: its own. Throws the errors of instances_of, Error "too-large" (binary glTF is limited to 4 GiB),
// "write-failed".
void write_glb(const std::filesystem::path&, const Particles&, const Shapes&,
               const std::string& provenance = {}, const Work& = {}, Instancing = Instancing::Extension,
               int materials = 64, const std::vector<std::int32_t>& index = {});

// Writes one node per shape, side by side along x, with the colors of shapes that have them. With `texture`,
// shapes with texture coordinates show it instead. Throws Error "no-shapes", "no-uv" if none has them,
// "too-large", "write-failed".
void write_glb(const std::filesystem::path&, const Shapes&, const std::string& provenance = {},
               const Work& = {}, const Image* texture = nullptr);

}  // namespace terrazzo::exporting

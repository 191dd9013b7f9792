// glTF 2.0 binary: particles as instances of their shapes (EXT_mesh_gpu_instancing), or shapes alone.
//
// Lengths: 1 mm is 0.001 m. Axes: glTF's y is up, ours is z, so every point, rotation and normal is turned by
// −90° about x: (x, y, z) → (x, z, −y). Colours are scene-linear, as glTF's factors are.
#pragma once

#include <filesystem>
#include <string>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo {

// One mesh and one node per shape that occurs; the node's instances have TRANSLATION, ROTATION, SCALE,
// `_COLOR_0` (three floats, scene-linear; three.js takes it as the instance's colour) and `_ID` (the
// particle's index, a float: exact below 2^24), in the order of the particles. Each particle of the periodic
// box is there once, its centre inside the box. `provenance`: a JSON object for asset.extras, or empty.
// Throws Error "no-particles", "no-such-shape", "bad-number" (NaN, infinity, a zero quaternion), "too-large"
// (glTF's binary form ends at 4 GiB), "write-failed".
void write_glb(const std::filesystem::path&, const Particles&, const Shapes&,
               const std::string& provenance = {}, const Work& = {});

// One node per shape, side by side along x. Throws Error "no-shapes" and as above.
void write_glb(const std::filesystem::path&, const Shapes&, const std::string& provenance = {},
               const Work& = {});

}  // namespace terrazzo

// Scenes for pbrt, version 4 (.pbrt). Lengths in mm, z up, colors scene-linear.
#pragma once

#include <filesystem>

#include "nodes/export/scene_parts.h"

namespace terrazzo::exporting {

// A camera, even light from all sides, one object per shape and color, and one instance per particle, in
// particle order. With a binder, its medium, from a NanoVDB file, fills a box without a surface of its own.
// `provenance` is a comment. Throws Error "write-failed", and Cancelled.
void write_pbrt(const std::filesystem::path&, const Scene&, const Work&);

}  // namespace terrazzo::exporting

// Scenes for Mitsuba 3 (.xml). Lengths in mm, z up, colors scene-linear.
#pragma once

#include <filesystem>

#include "nodes/export/scene_parts.h"

namespace terrazzo::exporting {

// A camera, even light from all sides, one shape group per shape and color, and one instance per particle, in
// particle order and with the particle's index in its id. With a binder, its medium fills a box without a
// surface of its own. `provenance` is a comment. Throws Error "write-failed", and Cancelled.
void write_mitsuba(const std::filesystem::path&, const Scene&, const Work&);

// The density of the binder as Mitsuba's grid volume (.vol, version 3).
void write_mitsuba_volume(const std::filesystem::path&, const BinderMedium&);

}  // namespace terrazzo::exporting

// Reads shapes from JSON, as Export writes them.
#pragma once

#include <string>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::load_shapes {

// Each entry of the list `shapes` has name, probability (0 to 1; they sum to 1), class (≥ −1), volume,
// surface_area, mean_caliper, max_section_area (> 0, mm), smooth, and `mesh`: vertices (mm), triangles, and
// optionally color and uv. Other fields are ignored. Numbers are read to the last bit; measures are not
// computed again. `file` is used in messages only. Throws Error "unreadable-file" if the structure is
// another, and with the index of the shape "bad-shape", "open-mesh", "inside-out".
Shapes read_shapes(const std::string& text, const std::string& file, const Work& = {});

}  // namespace terrazzo::load_shapes

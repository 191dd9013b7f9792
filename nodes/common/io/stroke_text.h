// Text form of strokes: "6: 10 20, 30 40" is a line of radius 6 through two points, "area: 0 0, 9 0, 5 8" the
// area inside an outline. More outlines follow after semicolons.
#pragma once

#include <string>

#include "nodes/data/strokes.h"

namespace terrazzo::strokes {

// Throws Error "bad-stroke" with the part that cannot be read.
Stroke read_stroke(const std::string&);
// The text reads back as the same numbers.
std::string write_stroke(const Stroke&);

}  // namespace terrazzo::strokes

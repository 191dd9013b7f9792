// SVG path data (SVG 1.1, section 8.3) as polylines.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::load_strokes {

// Returns one polyline per subpath; a closed subpath ends where it began. Curves become chords within
// `tolerance` of the curve. As SVG requires, an error ends the path; `broken` then says what is wrong and
// where. Throws Error "too-large" if the path has more than `most` points, since a few characters may produce
// thousands.
std::vector<std::vector<Vec2>> read_path(const std::string& data, double tolerance, std::string& broken,
                                         std::size_t most = std::size_t{1} << 32);

// An elliptical arc from `from` to `to` (SVG 1.1, F.6), without its first point.
std::vector<Vec2> arc_points(const Vec2& from, Vec2 radii, double turn_degrees, bool large, bool sweep,
                             const Vec2& to, double tolerance);

}  // namespace terrazzo::load_strokes

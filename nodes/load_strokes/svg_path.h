// SVG's path data (SVG 1.1, section 8.3) as polylines.
#pragma once

#include <string>
#include <vector>

#include "nodes/common/linear.h"

namespace terrazzo::load_strokes {

// One polyline a subpath; a closed one ends where it began. Curves become chords no farther than `tolerance`
// off them. As SVG asks, an error ends the path: `broken` then tells where it is. Throws Error "too-large" if
// the path has more than `most` points, for a few characters may stand for thousands.
std::vector<std::vector<Vec2>> read_path(const std::string& data, double tolerance, std::string& broken,
                                         std::size_t most = std::size_t{1} << 32);

// An arc of an ellipse from `from` to `to` (SVG 1.1, F.6), without its first point.
std::vector<Vec2> arc_points(const Vec2& from, Vec2 radii, double turn_degrees, bool large, bool sweep,
                             const Vec2& to, double tolerance);

}  // namespace terrazzo::load_strokes

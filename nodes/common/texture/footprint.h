// Pixels covered by strokes.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/strokes.h"

namespace terrazzo {

// Increasing pixel indices (row from the top · width + column) of the pixels whose centers are within
// `radius` of the segment, or of the point if both ends coincide.
std::vector<std::uint32_t> capsule(int width, int height, const Vec2& from, const Vec2& to, double radius);
// Pixels whose centers are enclosed by an odd number of outlines.
std::vector<std::uint32_t> surrounded(int width, int height, const std::vector<std::vector<Vec2>>& outlines);

// All pixels of a stroke, sorted and unique, dilated by `margin` pixels.
std::vector<std::uint32_t> footprint_of(const Stroke&, int width, int height, double margin = 0);

}  // namespace terrazzo

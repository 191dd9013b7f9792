// Which pixels strokes cover.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/strokes.h"

namespace terrazzo {

// Pixels of a picture by number, row from the top · width + column, rising: those whose centres lie no
// further than `radius` from the segment, a disc where both ends are one point.
std::vector<std::uint32_t> capsule(int width, int height, const Vec2& from, const Vec2& to, double radius);
// Those whose centres an odd number of outlines surround.
std::vector<std::uint32_t> surrounded(int width, int height, const std::vector<std::vector<Vec2>>& outlines);

// All of a stroke's, each once, rising; `margin` pixels more on all sides.
std::vector<std::uint32_t> footprint_of(const Stroke&, int width, int height, double margin = 0);

}  // namespace terrazzo

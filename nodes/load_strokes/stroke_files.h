// Strokes from files. Both readers throw Error "too-large" if the strokes would exceed the budget.
#pragma once

#include <filesystem>

#include "nodes/common/reading.h"
#include "nodes/data/strokes.h"

namespace terrazzo::load_strokes {

// A list `strokes` of {radius, points} and {area: true, points} or {area: true, parts}, points as [x, y]; or
// of words as in the Strokes node. Throws Error "bad-strokes-file" with the line, "unreadable-file".
Strokes read_yaml(const std::filesystem::path&, const Reading& = {});

// Paths, polylines, polygons, lines, rectangles, circles and ellipses, in the order of the file, transforms
// and viewBox applied. What has a stroke is a line of half the stroke's width for each of its subpaths
// (curves as chords no farther than 0.1 units off), else what is filled is an area; what has neither, or is
// not displayed, is left out, and so are text, pictures and what stands in <defs>. Throws Error
// "bad-strokes-file", "unreadable-file".
Strokes read_svg(const std::filesystem::path&, const Reading& = {});

}  // namespace terrazzo::load_strokes

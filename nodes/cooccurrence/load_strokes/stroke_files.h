// Strokes from files. Both readers throw Error "too-large" if the strokes would exceed the memory budget.
#pragma once

#include <filesystem>

#include "nodes/common/io/reading.h"
#include "nodes/data/strokes.h"

namespace terrazzo::load_strokes {

// Reads a list `strokes` of {radius, points}, {area: true, points} or {area: true, parts}, with points as [x,
// y], or of text entries as in the Strokes node. Throws Error "bad-strokes-file" with the line,
// "unreadable-file".
Strokes read_yaml(const std::filesystem::path&, const Reading& = {});

// Reads paths, polylines, polygons, lines, rectangles, circles and ellipses in file order, with transforms
// and viewBox applied. A shape with a stroke becomes one line per subpath, with half the stroke's width as
// radius; curves become chords within 0.1 units of the curve. A shape with only a fill becomes an area.
// Shapes with neither, hidden shapes, text, images and the content of <defs> are ignored. Throws Error
// "bad-strokes-file", "unreadable-file".
Strokes read_svg(const std::filesystem::path&, const Reading& = {});

}  // namespace terrazzo::load_strokes

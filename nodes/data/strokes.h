// Strokes: strokes of a nib or brush on an image.
#pragma once

#include <vector>

#include "nodes/data/linear.h"
#include "runtime/value.h"

namespace terrazzo {

struct Stroke {
  // Pixels from the top left corner of the image, x to the right, y down; pixel (0, 0) covers [0, 1)². A line
  // has one part; a single point is a dab. An area covers the points enclosed by an odd number of its
  // outlines.
  std::vector<std::vector<Vec2>> parts;
  double radius = 0;  // of the round nib, pixels
  bool area = false;  // fill the outlines instead of drawing along them
};

struct Strokes {
  std::vector<Stroke> strokes;  // in drawing order
};

template <>
const ValueType& value_type<Strokes>();

// Throws Error "bad-stroke" for an invalid stroke: no points, a number that is not finite or beyond ±10⁶, an
// area outline with fewer than three points, a line with more than one part or with a radius of 0.
void check_stroke(const Stroke&);

}  // namespace terrazzo

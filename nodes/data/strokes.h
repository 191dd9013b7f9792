// Strokes: where a nib or brush went over a picture.
#pragma once

#include <vector>

#include "nodes/common/linear.h"
#include "runtime/value.h"

namespace terrazzo {

struct Stroke {
  // Pixels from the picture's upper left corner, x to the right, y down; pixel (0, 0) covers [0, 1)². A line
  // has one part, a single point is a dab. An area is what an odd number of its parts' outlines surround.
  std::vector<std::vector<Vec2>> parts;
  double radius = 0;  // of the round nib, pixels
  bool area = false;  // fills what the parts surround, in the place of going along them
};

struct Strokes {
  std::vector<Stroke> strokes;  // in the order in which they were drawn
};

template <>
const ValueType& value_type<Strokes>();

// Throws Error "bad-stroke" for what is no stroke: no points, numbers that are not finite or beyond ±10⁶, an
// area of fewer than three points, a line with a radius of 0.
void check_stroke(const Stroke&);

}  // namespace terrazzo

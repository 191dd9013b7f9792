// Equal steps in the coordinates of points, in any order, and as rounded as files have them.
#pragma once

#include <optional>
#include <vector>

#include "nodes/photograph/load_ebsd/map_text.h"

namespace terrazzo::load_ebsd {

struct Axis {
  double origin = 0, step = 0;  // µm; the step is 0 if all points have one coordinate and the header no step
  bool half = false;            // the step is half of the header's, as across the rows of a hexagonal grid
  std::int64_t count = 1;       // of steps, from the first coordinate to the last, plus one
  std::vector<std::int32_t> at;  // number of steps of each point from the origin
};

struct AxisCoordinates {
  const char* name;  // "x"
  const std::vector<double>& values;
  double digit;  // unit of their last digit
  std::optional<HeaderNumber> header_step;
  const char* header_name;
  const std::vector<std::int32_t>& line;
};

// Throws Error "malformed-row" with the first line whose coordinate contradicts the step of the header or
// equal steps, "unreadable-file" if there are more than 2²⁴ steps.
Axis find_axis(const AxisCoordinates&, const Lines&);

}  // namespace terrazzo::load_ebsd

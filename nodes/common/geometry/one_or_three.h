// Reads a parameter with one number for all axes or one number per axis.
#pragma once

#include <string>

#include "graph/diagnostic.h"
#include "graph/node_parameters.h"
#include "nodes/data/linear.h"

namespace terrazzo {

// Throws Error "bad-value" for two numbers.
inline Vec3i one_or_three(const NodeParameters& c, const std::string& parameter) {
  const auto written = c.ints(parameter);
  if (written.size() == 2)
    throw Error("bad-value", "the value has two numbers", "write one number, or three for x, y and z")
        .parameter(parameter);
  Vec3i out;
  for (int a = 0; a < 3; ++a)
    out[a] = static_cast<int>(written[written.size() == 1 ? 0 : static_cast<std::size_t>(a)]);
  return out;
}

}  // namespace terrazzo

// A parameter of one number for all axes, or of one for each.
#pragma once

#include <string>

#include "graph/diagnostic.h"
#include "nodes/common/linear.h"
#include "runtime/context.h"

namespace terrazzo {

// Throws Error "bad-value" where there are two.
inline Vec3i one_or_three(const Context& c, const std::string& parameter) {
  const auto written = c.ints(parameter);
  if (written.size() == 2)
    throw Error("bad-value", "two numbers", "write one number, or three").parameter(parameter);
  Vec3i out;
  for (int a = 0; a < 3; ++a)
    out[a] = static_cast<int>(written[written.size() == 1 ? 0 : static_cast<std::size_t>(a)]);
  return out;
}

}  // namespace terrazzo

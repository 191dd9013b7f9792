// Evenly spread directions.
#pragma once

#include <cmath>
#include <cstddef>

#include "nodes/common/linear.h"

namespace terrazzo {

// The i-th of n directions on the hemisphere z > 0, each representing an equal area: a Fibonacci lattice
// (González 2010). Opposite directions have the same sections, so a hemisphere is sufficient.
inline Vec3 half_sphere_direction(std::size_t i, std::size_t n) {
  const double z = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
  const double r = std::sqrt(1 - z * z), phi = 2.399963229728653 * static_cast<double>(i);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

}  // namespace terrazzo

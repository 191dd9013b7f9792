// Evenly spread directions.
#pragma once

#include <cmath>
#include <cstddef>

#include "nodes/common/linear.h"

namespace terrazzo {

// The i-th of n directions on the half sphere z > 0, of equal area each: a Fibonacci lattice (González 2010).
// Opposite directions see the same sections, so half a sphere is all.
inline Vec3 half_sphere_direction(std::size_t i, std::size_t n) {
  const double z = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
  const double r = std::sqrt(1 - z * z), phi = 2.399963229728653 * static_cast<double>(i);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

}  // namespace terrazzo

// Evenly spread and random directions, and random rotations.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>

#include "nodes/data/linear.h"
#include "runtime/random.h"

namespace terrazzo {

// The i-th of n directions on the hemisphere z > 0, each representing an equal area: a Fibonacci lattice
// (González 2010). Opposite directions have the same sections, so a hemisphere is sufficient.
inline Vec3 half_sphere_direction(std::size_t i, std::size_t n) {
  const double z = (static_cast<double>(i) + 0.5) / static_cast<double>(n);
  const double r = std::sqrt(1 - z * z), phi = 2.399963229728653 * static_cast<double>(i);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// A direction drawn uniformly from the sphere.
inline Vec3 random_direction(Random& r) {
  const double z = r.uniform(-1, 1), a = r.uniform(0, 2 * std::numbers::pi), s = std::sqrt(1 - z * z);
  return {s * std::cos(a), s * std::sin(a), z};
}

// A rotation drawn uniformly from all (Shoemake 1992).
inline Quat random_rotation(Random& r) {
  const double u = r.uniform(), a = 2 * std::numbers::pi * r.uniform(),
               b = 2 * std::numbers::pi * r.uniform();
  return Quat(std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a),
              std::sqrt(u) * std::sin(b));
}

// Four independent normal numbers; normalized, a rotation drawn uniformly from all. With random_rotation(),
// the results of Anneal, Pack and RenderVolume would change.
inline Quat random_quaternion(Random& r) {
  Quat q;
  for (double* c : {&q.z(), &q.y(), &q.x(), &q.w()}) *c = r.normal();
  return q;
}

}  // namespace terrazzo

// An exemplar by formula, for benchmarks of solids.
#pragma once

#include <cmath>

#include "nodes/solids/synthesis/optimize_solid.h"
#include "runtime/random.h"

namespace terrazzo::bench {

// Value noise: blobs with a rim, and grain. `side` in pixels.
inline solids::SolidExemplar blobs(int side) {
  solids::SolidExemplar e;
  e.width = e.height = side;
  const auto lattice = [](int i, int j) {
    return Random(3, static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(j)).uniform();
  };
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double u = x / 7.0, v = y / 7.0, fu = u - std::floor(u), fv = v - std::floor(v);
      const int i = static_cast<int>(u), j = static_cast<int>(v);
      const double n = (1 - fv) * ((1 - fu) * lattice(i, j) + fu * lattice(i + 1, j)) +
                       fv * ((1 - fu) * lattice(i, j + 1) + fu * lattice(i + 1, j + 1));
      const double t = 1 / (1 + std::exp(-25 * (n - 0.5))), rim = std::exp(-400 * (n - 0.5) * (n - 0.5));
      const double grain = 0.03 * Random(4, 0, static_cast<std::uint64_t>(y) * side + x).normal();
      e.pixels.push_back(Vec3f(static_cast<float>(0.15 + 0.6 * t + grain),
                               static_cast<float>(0.2 + 0.3 * t + 0.3 * rim + grain),
                               static_cast<float>(0.4 - 0.2 * t + grain))
                             .cwiseMax(0.0f));
    }
  return e;
}

}  // namespace terrazzo::bench

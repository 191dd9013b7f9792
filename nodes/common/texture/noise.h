// Solid noise functions.
#pragma once

#include <cstdint>

#include "nodes/data/linear.h"

namespace terrazzo {

// Gradient noise (Perlin 2002) on a lattice of step 1: mean 0, within −1 … 1, smooth.
double noise(std::uint64_t seed, const Vec3& p);
// Sum of octaves of noise, each with twice the frequency and half the amplitude.
double turbulence(std::uint64_t seed, const Vec3& p, int octaves);

// Cellular noise (Worley 1996) with one random point per unit cube.
struct Cell {
  double edge = 0;   // distance to the second nearest point minus that to the nearest
  double shade = 0;  // 0 … 1, constant within a cell
};
Cell cellular(std::uint64_t seed, const Vec3& p);

}  // namespace terrazzo

// Noise in space.
#pragma once

#include <cstdint>

#include "nodes/common/linear.h"

namespace terrazzo {

// Gradient noise (Perlin 2002) on a lattice of step 1: mean 0, within −1 … 1, smooth.
double noise(std::uint64_t seed, const Vec3& p);
// Octaves of it, each of twice the frequency and half the amplitude.
double turbulence(std::uint64_t seed, const Vec3& p, int octaves);

// Worley 1996: one random point in each unit cube; the cells nearest to each.
struct Cell {
  double edge = 0;   // distance to the second nearest point less that to the nearest
  double shade = 0;  // 0 … 1, the cell's own
};
Cell cellular(std::uint64_t seed, const Vec3& p);

}  // namespace terrazzo

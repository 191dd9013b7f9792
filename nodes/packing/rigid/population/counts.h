// The box of a population, and how many particles of each size class it holds.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/packing/rigid/population/population.h"

namespace terrazzo::packing {

// Particles of one entry of the distribution in one size class.
struct Cell {
  int entry, cls;      // entry of the distribution, size class
  double density;      // per mm³
  double mean_volume;  // mm³
  std::int64_t count = 0;
};

struct PopulationCounts {
  std::vector<Cell> cells;  // largest class first
  Vec3 box = Vec3::Zero();  // mm
  double diameter = 0;      // mm, bounding, of the largest particle
  double expected = 0;      // number of particles, not rounded
};

// Volume of a particle of unit size.
double unit_volume(const Shape&);

// Sets the fractions, sizes, expected numbers and notes of the population. Throws Error "no-particles",
// "impossible-density", "bad-size", "box-too-small", "too-many-particles".
PopulationCounts count_particles(const SizeDistribution&, const Shapes&, const PopulationOptions&,
                                 Population&);

}  // namespace terrazzo::packing

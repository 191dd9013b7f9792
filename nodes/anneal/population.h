// Which particles a box holds: counts, shapes and sizes from a distribution of densities.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "runtime/work.h"

namespace terrazzo::anneal {

struct PopulationOptions {
  std::vector<double> edges;  // mm, one to three (node.cpp tells); empty: a cube for about `count` particles
  std::int64_t count = 2000;
  std::int64_t most = 1'000'000;     // refuses more
  bool keep_volume_fraction = true;  // where densities and volume fraction disagree, the fraction holds
  double binder_gap = 0;             // mm
  bool all_void = false;
  std::vector<std::int64_t> void_classes;  // whose particles are without matter
  std::uint64_t seed = 1;
};

struct Population {
  Particles particles;   // positions of the kept ones only; scale and size of all. Kept ones first, then
                         // largest first
  std::size_t kept = 0;  // from `start`
  std::vector<int> size_class;     // of each particle
  double requested_fraction = 0;   // Σ N_V·V
  double fraction = 0;             // of the particles listed
  std::vector<double> expected;    // particles of each size class in this box, not rounded
  std::vector<std::string> notes;  // for the user
};

// Counts by rounding the running sum from the largest class down, at the phase that meets the volume fraction
// best; sizes stratified within their class and bent within it until the fraction is met. Shapes of entries
// with shape −1 are drawn evenly by probability. Particles of `start` (may be null) whose class has room are
// kept. Throws Error "bad-distribution", "no-particles", "box-too-small", "too-many-particles",
// "impossible-density", "open-mesh", "no-such-class".
Population populate(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                    const PopulationOptions& options, const Work& work = {});

}  // namespace terrazzo::anneal

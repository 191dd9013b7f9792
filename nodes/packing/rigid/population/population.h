// Determines the particles of a box: counts, shapes and sizes from a distribution of number densities.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "nodes/packing/rigid/population/clusters.h"
#include "runtime/work.h"

namespace terrazzo::packing {

// What to keep if densities and volume fraction contradict.
enum class Conserve { VolumeFraction, NumberDensity };

struct PopulationOptions {
  std::vector<double> edges;  // mm, one to three as in node.cpp; empty: a cube for about `count` particles
  std::int64_t count = 2000;
  std::int64_t most = 1'000'000;  // largest number of particles
  Conserve conserve = Conserve::VolumeFraction;
  double binder_gap = 0;     // mm
  bool fills_space = false;  // the particles may fill the whole box; larger volume fractions become 1
  bool all_void = false;
  std::vector<std::int64_t> void_classes;  // classes whose particles are voids
  std::uint64_t seed = 1;
  Clusters clusters;  // in which small particles are placed
};

// An automatic box is made larger than for `count` particles, so that it shows many of the largest ones, as
// long as it holds at most this many particles in all and at most ten times `count`.
inline constexpr double kMostEnlarged = 2500;
// If even the smallest box in which the largest particle fits would hold more than this and `count`, the
// smallest particles are left out.
inline constexpr double kMostKept = 5000;
double most_enlarged(const PopulationOptions&);

struct Population {
  // Scale and size of all particles; positions only of the kept ones. Kept particles are first, then the
  // others by decreasing size.
  Particles particles;
  std::size_t kept = 0;           // number of particles from `start`
  double start_shrink = 1;        // factor by which the kept ones were smaller in `start`; see shrunk_start.h
  std::vector<int> size_class;    // of each particle
  double requested_fraction = 0;  // Σ N_V·V
  double left_out_fraction = 0;   // the part of it in particles that are left to the binder
  double left_out_size = 0;       // mm: they are smaller than this
  double target_fraction = 0;     // the rest: what the particles are to fill
  double fraction = 0;            // volume fraction of the particles
  std::vector<double> expected;   // number of particles of each size class in this box, not rounded
  std::vector<std::string> notes;  // warnings for the user
};

// Counts come from rounding the running sum from the largest class down, with the offset that best
// matches the volume fraction. Sizes are stratified within their class and shifted within it until
// the fraction matches. Shapes of entries with shape −1 are drawn in proportion to their
// probabilities. Particles of `start` (may be null) are kept if their class has room. Throws Error
// "no-shapes", "bad-shape", "bad-distribution", "bad-size", "no-particles", "box-too-small",
// "too-many-particles", "impossible-density", "open-mesh", "no-such-class".
Population populate(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                    const PopulationOptions& options, const Work& work = {});

}  // namespace terrazzo::packing

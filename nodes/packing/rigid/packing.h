// From a distribution and shapes to particles without overlap: population, placement, annealing, audit.
#pragma once

#include <functional>
#include <optional>

#include "nodes/packing/rigid/population/population.h"
#include "runtime/work.h"

namespace terrazzo::packing {

enum class OnJam { Fail, Shrink, Drop };

// What a canceled packing had reached.
struct InterruptedPacking {
  Particles particles;  // in their order, at the size they had
  double overlap = 0;   // deepest, as far as known, relative to the smaller particle's size; 0: free
};

struct PackOptions {
  PopulationOptions population;
  OnJam on_jam = OnJam::Fail;
  // Particles lie with their flat side down (lying.h) instead of at random, and turn little (kMostTurn, in
  // each run that continues).
  bool lying = false;
  std::vector<double> long_axes;  // radians; directions of lying particles' long axes; empty: at random
  int iterations = 6000;          // steps until the particles are considered jammed; see Budget
  // Shrink: volume fraction that must be reached; refused at once if a sample of the particles jams below it,
  // or so little above that all would.
  double least = 0;
  // Called if the packing is canceled after particles have been moved, before Cancelled is thrown: with the
  // densest packing found that is free of overlap, or if there is none, with the current one. As `start` of
  // the same request it continues from there, and the result is at least as dense, apart from what the audit
  // corrects and what Drop leaves out.
  std::function<void(const InterruptedPacking&)> interrupted;
};

struct PackResult {
  Particles particles;
  std::vector<int> size_class;   // of each particle
  std::vector<double> expected;  // number of particles requested in each class
  double requested_fraction = 0;
  double left_out_fraction = 0;  // the part of it that is left to the binder; see Population
  double max_penetration = 0;    // from the audit, relative to the smaller particle's size
  double reachable = 0;          // volume fraction that the estimate expected to reach; 0 without an estimate
  // Mean number of neighbors within 1 % of the smaller particle's size; nothing: not counted.
  std::optional<double> coordination;
  double shrink = 1;     // all particles were scaled by this factor
  std::size_t kept = 0;  // number of particles kept from `start`
  std::size_t dropped = 0;
  double dropped_volume = 0;       // mm³
  int iterations = 0;              // of all bodies
  double steps = 0;                // work done without the trial; see Budget
  std::vector<std::string> notes;  // warnings for the user
};

// Sets what was requested: classes, numbers, fractions and notes.
void set_request(PackResult&, const Population&);

// Deepest penetration that the audit accepts, relative to the smaller particle's size.
inline constexpr double kTolerance = 1e-4;

// Estimates first how dense the particles can be. If more is requested and on_jam is Shrink or Drop, slightly
// less than the estimate is packed. The work is bounded for any shapes and densities. Throws the errors of
// populate() and limits.h. Throws Error "jammed" with the volume fraction reached if the
// particles cannot be packed and on_jam is Fail, or reach less than `least`, "overlap" if the audit finds
// overlaps that cannot be removed.
PackResult pack_particles(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                          const PackOptions& options, const Work& work = {});

}  // namespace terrazzo::packing

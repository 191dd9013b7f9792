// Estimates how dense a population can be packed, before it is packed.
#pragma once

#include "nodes/packing/rigid/population/population.h"
#include "nodes/packing/rigid/schedule.h"

namespace terrazzo::packing {

struct Reachable {
  double fraction = 0;  // volume fraction that a trial reached; at least that is possible
  bool jammed = false;  // the trial reached less than requested, so more is unlikely
  double steps = 0;     // that the trial took
};

// The volume fraction at which the bounding balls of the particles can be packed without effort. Any request
// below is possible.
double surely_reachable(const Population& population, const Shapes& shapes,
                        const std::vector<ContactShape>& contact_shapes, double binder_gap);

// Packs about 200 particles, every k-th by size, into a small periodic cube at the requested density, or as
// dense as they get in `options.steps` steps. `fraction` is 0 if there are too few particles for a trial:
// fewer than three times as many, or if the largest particle needs a box for more than half of them.
Reachable try_sample(const Population& population, const Shapes& shapes,
                     const std::vector<ContactShape>& contact_shapes, const AnnealOptions& options,
                     const Work& work = {});

}  // namespace terrazzo::packing

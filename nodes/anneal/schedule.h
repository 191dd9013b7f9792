// The annealing schedule: from any first placement to a packing without overlap.
#pragma once

#include "nodes/anneal/relaxation.h"

namespace terrazzo::anneal {

struct AnnealOptions {
  double binder_gap = 0;  // smallest distance between surfaces, mm
  std::uint64_t seed = 1;
  int iterations = 4000;      // of all bodies, at most
  double start_shrink = 0.6;  // size at which growth begins
  bool settle = false;        // only mend a packing that is almost free, at the size it has
  double aim = 1;     // a size beyond 1 to reach where it takes no rounds: leaves room for the audit's finds
  double enough = 1;  // where the bodies jam, a size at which to stop growing
  Detail detail = Detail::Fine;  // of contacts once the bodies have their size
  Margins extra;
};

struct AnnealResult {
  bool free = false;  // no overlap at packing.shrink
  int iterations = 0;
  Overlap overlap;  // what is left
};

// Bodies grow from `start_shrink` to their size while overlaps are relaxed; where they jam they are shaken at
// a falling temperature and grown again. Ends with packing.shrink = 1 and free, or, the iterations used up,
// with the densest free state found (shrink < 1).
AnnealResult pack(const std::vector<ContactShape>& shapes, Packing& packing, const AnnealOptions& options,
                  const Work& work);

// Deepest contact of each body where all have the size packing.shrink, in its own size; 0 where it is free.
std::vector<double> strain_of(const std::vector<ContactShape>& shapes, Packing& packing,
                              const AnnealOptions& options, const Work& work);

// Mean number of neighbours nearer than `within` of the smaller one's size.
double coordination_number(const std::vector<ContactShape>& shapes, Packing& packing, double within,
                           const Work& work);

}  // namespace terrazzo::anneal

// The annealing schedule: from any initial placement to a packing without overlap.
#pragma once

#include "nodes/packing/rigid/budget.h"
#include "nodes/packing/rigid/relaxation.h"

namespace terrazzo::packing {

struct AnnealOptions {
  double binder_gap = 0;  // smallest distance between surfaces, mm
  std::uint64_t seed = 1;
  double steps = 4000;        // largest number of steps of this call; also ends with the budget
  double start_shrink = 0.6;  // size at which growth begins
  bool local = false;         // while settling, move only bodies that overlap
  bool settle = false;        // only repair a packing that is almost free, at its current size
  bool overlaps = false;      // once the steps are used up, the result may overlap
  bool resume = false;        // the bodies may be free at start_shrink; then the result is at least as dense
  double aim = 1;  // size above 1 to reach if no rounds are needed; leaves room for corrections by the audit
  double enough = 1;                           // size at which jammed bodies stop growing
  ContactDetail detail = ContactDetail::Fine;  // detail of contacts once the bodies have their size
  Margins extra;
};

struct AnnealResult {
  bool free = false;   // no overlap at packing.shrink
  int iterations = 0;  // of all bodies
  double steps = 0;    // as charged to the budget
  Overlap overlap;     // remaining overlap
};

// Bodies grow from `start_shrink` to their size while overlaps are relaxed. If they jam, rounds of agitated
// compression and decompression make them denser. Ends with packing.shrink = 1 and free or, if the steps are
// used up or the rounds stop gaining, with the densest free state found (shrink < 1). Charges the budget, and
// exceeds it only to find a first free state. If canceled, leaves the densest free state found so far in
// `packing`, or else the current one.
AnnealResult pack(const std::vector<ContactShape>& shapes, Packing& packing, const AnnealOptions& options,
                  Budget& budget, const Work& work);

// Deepest contact of each body at the size packing.shrink, relative to its own size; 0 if the body is free.
std::vector<double> strain_of(const std::vector<ContactShape>& shapes, Packing& packing,
                              const AnnealOptions& options, const Work& work);

// Mean number of neighbors at a distance of less than `within` times the smaller size.
double coordination_number(const std::vector<ContactShape>& shapes, Packing& packing, double within,
                           const Work& work);

}  // namespace terrazzo::packing

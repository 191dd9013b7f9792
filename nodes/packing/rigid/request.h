// Parameters shared by the nodes that pack particles.
#pragma once

#include "graph/node_type.h"
#include "nodes/packing/rigid/population/population.h"
#include "runtime/context.h"

namespace terrazzo::packing {

// Declares `size`, `count`, `seed` and `conserve`.
NodeType& declare_population(NodeType&);
// Their values.
PopulationOptions read_population(const Context&);
// Sets the metrics `particles`, `packing_fraction` and `requested_fraction`, with an automatic box
// `requested_count`, and those of classes that are left to the binder. Warns if the number of particles in an
// automatic box differs by more than 10 % from `count`, or the volume fraction by more than 0.5 % from what
// was requested; `explained`: another warning says why the fraction is lower, or that particles were left
// out.
void report_population(Context&, const Particles&, double fraction, double requested_fraction,
                       double left_out_fraction, bool explained);

}  // namespace terrazzo::packing

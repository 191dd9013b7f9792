// Parameters shared by the nodes that pack particles.
#pragma once

#include "graph/node_type.h"
#include "nodes/packing/population.h"
#include "runtime/context.h"

namespace terrazzo::packing {

// Declares `size`, `count`, `seed` and `conserve`.
NodeType& declare_population(NodeType&);
// Their values.
PopulationOptions read_population(const Context&);

}  // namespace terrazzo::packing

// Parameters and outputs shared by the nodes that fill space with particles.
#pragma once

#include "graph/node_type.h"
#include "nodes/packing/cells/fill_space.h"
#include "runtime/context.h"

namespace terrazzo::tessellation {

// Declares everything except the method and the parameters of the population.
NodeType& declare_fill(NodeType&);
// If the filling is canceled, what it has reached is saved with Context::save_interrupted.
FillOptions read_fill(Context&, Method method);
// Throws Error "bad-stretch" unless `stretch` has one or three values.
void check_fill(const NodeParameters&);
// Sets metrics, warnings, and the outputs `particles`, `shapes`, `table` and `figure`.
void output_fill(Context&, const SizeDistribution&, FillResult);

}  // namespace terrazzo::tessellation

// Outputs shared by the nodes that make solids.
#pragma once

#include <memory>
#include <vector>

#include "graph/node_type.h"
#include "nodes/solids/synthesis/blockwise/gl.h"
#include "nodes/solids/synthesis/optimize_solid.h"
#include "runtime/context.h"

namespace terrazzo::solids {

// Opens the device that the parameter device selects for a blockwise solid's finer levels: a GPU or Mesa's
// software renderer, or null for the processor. Warns which one it is, unless device is cpu.
std::unique_ptr<BlockGl> open_device(Context&);

// Sets the outputs `volume` and `table`, and metrics. Voxels have an edge of `voxel` mm. The grid features is
// added if the exemplars have features, the grid source if the parameter sources is set.
void give_solid(Context&, SolidResult&&, const std::vector<SolidExemplar>&, bool whole, double voxel,
                const Work&);

// Declare the outputs, and the parameters device and sources.
NodeType& declare_solid(NodeType&);
NodeType& declare_device(NodeType&);
NodeType& declare_sources(NodeType&);

}  // namespace terrazzo::solids

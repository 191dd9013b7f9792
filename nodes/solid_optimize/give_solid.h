// What the nodes that make solids give.
#pragma once

#include <memory>
#include <vector>

#include "graph/node_type.h"
#include "nodes/solid_optimize/local_gl.h"
#include "nodes/solid_optimize/solid_optimize.h"
#include "runtime/context.h"

namespace terrazzo::solid_optimize {

// What makes a local solid's finer levels by the parameter device: a GPU, Mesa's software renderer, or
// nothing, which means the processor itself. Warns which it is.
std::unique_ptr<LocalGl> open_device(Context&);

// Outputs `volume` and `table`, and metrics. Voxels are `voxel` mm; the grid features where the exemplars
// have any, source where the parameter sources says so.
void give_solid(Context&, SolidResult&&, const std::vector<SolidExemplar>&, bool whole, double voxel,
                const Work&);

// The outputs, and the parameters device and sources.
NodeType& declare_solid(NodeType&);
NodeType& declare_device(NodeType&);
NodeType& declare_sources(NodeType&);

}  // namespace terrazzo::solid_optimize

// What the nodes that make solids read of their inputs and parameters.
#pragma once

#include <vector>

#include "graph/node_type.h"
#include "nodes/solid_optimize/solid_optimize.h"
#include "runtime/context.h"

namespace terrazzo::solid_optimize {

// Exemplars at the solid's scale, and all settings but method, blocks and sources.
struct SolidRequest {
  std::vector<SolidExemplar> exemplars;
  SolidSettings settings;
  double voxel = 1;  // mm
};

// `method` is how the solid is made: it decides what auto stands for.
SolidRequest read_request(Context&, const std::string& method);
// Throws Error "too-large" where `bytes` are more than the parameter memory allows; warns of an exemplar that
// shows too little of its own structure.
void check_request(Context&, const SolidRequest&, double bytes);

// The inputs and parameters that they read, in two parts so that a node's own may stand between.
NodeType& declare_exemplars(NodeType&);
NodeType& declare_size(NodeType&);
NodeType& declare_settings(NodeType&);

}  // namespace terrazzo::solid_optimize

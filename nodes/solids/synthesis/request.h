// Inputs and parameters shared by the nodes that make solids.
#pragma once

#include <vector>

#include "graph/node_type.h"
#include "nodes/solids/synthesis/optimize_solid.h"
#include "runtime/context.h"

namespace terrazzo::solids {

// Exemplars at the solid's scale, and all settings except method, blocks and sources.
struct SolidRequest {
  std::vector<SolidExemplar> exemplars;
  SolidOptions settings;
  double voxel = 1;  // mm
};

// `method` is the effective method; it decides the values of auto.
SolidRequest read_request(Context&, SolidMethod method);
// Throws Error "too-large" if `bytes` exceed the parameter memory. Warns if an exemplar shows too little of
// its own structure.
void check_request(Context&, const SolidRequest&, double bytes);

// Declare these inputs and parameters, in three parts so that a node's own can go in between.
NodeType& declare_exemplars(NodeType&);
NodeType& declare_size(NodeType&);
NodeType& declare_settings(NodeType&);

}  // namespace terrazzo::solids

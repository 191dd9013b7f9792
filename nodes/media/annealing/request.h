// Inputs, parameters and outputs that the nodes which make solids of phases share.
#pragma once

#include <vector>

#include "graph/node_type.h"
#include "nodes/media/annealing/anneal.h"
#include "runtime/context.h"

namespace terrazzo::annealing {

struct PhaseRequest {
  std::vector<media::PhaseMap> maps;  // at least one, with equal phases and pixels
  std::vector<Vec3f> color;           // of each phase
  AnnealOptions options;
};

// Throws the errors of the inputs and parameters below. Warns of pictures that say little.
PhaseRequest read_request(Context&);
// The outputs `table` and `figure`, and the metrics. `options.size` must be the solid's.
void give_agreement(Context&, const PhaseRequest&, const Solid&, const Work&);

// Inputs `image`, `labels`, `masks`; outputs `table`, `figure`; parameters `size`, `planes`, `seed`.
NodeType& declare_pictures(NodeType&);
NodeType& declare_agreement(NodeType&);
NodeType& declare_settings(NodeType&, int least_edge);

}  // namespace terrazzo::annealing

// What optimization blurs, given back.
#pragma once

#include "nodes/solid_optimize/solid_optimize.h"

namespace terrazzo::solid_optimize {

// The finest two scales of bands on all slices of each constrained axis get their exemplar's distribution
// (ResidualSynth's slice families), then voxels get the exemplars' values; `rounds` times.
void finish_bands(const std::vector<SolidExemplar>& working, const SolidSettings&, SolidField&, const Work&);

}  // namespace terrazzo::solid_optimize

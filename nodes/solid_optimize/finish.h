// What optimization blurs, given back.
#pragma once

#include <cstddef>

#include "nodes/solid_optimize/solid_optimize.h"

namespace terrazzo::solid_optimize {

// The high-pass and the three finest scales of bands on all slices of each constrained axis get their
// exemplar's distribution (ResidualSynth's slice families), then voxels get the exemplars' values; `rounds`
// times.
void finish_bands(const std::vector<SolidExemplar>& working, const SolidSettings&, SolidField&, const Work&);

// Of what each of `planes` planes wants changed in a round: a wave is seen by two of three, and a mean would
// need more rounds.
inline float finish_share(std::size_t planes) {
  return planes > 2 ? 2.0f / static_cast<float>(planes) : 1.0f;
}

}  // namespace terrazzo::solid_optimize

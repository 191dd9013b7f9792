// Restores detail that optimization blurs.
#pragma once

#include <cstddef>

#include "nodes/solids/synthesis/options/solid_options.h"
#include "nodes/solids/synthesis/whole/result.h"

namespace terrazzo::solids {

// Matches the high-pass and the three finest scales of bands on all slices of each constrained axis to the
// exemplar's distribution (ResidualSynth's slice families), then matches the voxels to the exemplars' values.
// Repeats this `finish` times.
void finish_bands(const std::vector<SolidExemplar>& working, const SolidOptions&, SolidField&, const Work&);

// Fraction of each plane's changes that is applied in a round with `planes` planes. Two of three planes see a
// wave, so with three planes a mean would need more rounds.
inline float finish_share(std::size_t planes) {
  return planes > 2 ? 2.0f / static_cast<float>(planes) : 1.0f;
}

}  // namespace terrazzo::solids

// Gives a synthesized field the source's own colors, arranged so that shapes survive.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/texture/color_levels.h"
#include "nodes/common/texture/cooccurrence.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::cooccurrence_synth {

// Finds for every pixel of the field the source pixel (index in Image::pixels) with the most similar 9 × 9
// neighborhood. Candidates are the neighbors' sources, shifted, and random ones (Ashikhmin 2001, Barnes
// 2009): one pass row by row, then three more rounds. Similarity alone favors smooth areas, so a source is
// penalized if the matrix `wanted` says that its level is overused beside the neighbors. Updates the field's
// levels to match. `sections` holds the source's levels, kNoLevel for pixels that must not be used.
std::vector<std::uint32_t> patch_sources(const Image& source, const std::vector<LevelField>& sections,
                                         const ColorLevels&, const Cooccurrence& wanted, bool periodic,
                                         std::uint64_t seed, LevelField& field, const Work& = {});

}  // namespace terrazzo::cooccurrence_synth

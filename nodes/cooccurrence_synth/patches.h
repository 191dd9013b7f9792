// A synthesised field in the source's own colours, laid so that shapes survive.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/color_levels.h"
#include "nodes/common/cooccurrence.h"
#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::cooccurrence_synth {

// For every pixel of the field a pixel of the source (number in Image::pixels), whose 9 × 9 surroundings look
// most alike: found among the neighbours' sources, shifted, and random ones (Ashikhmin 2001, Barnes 2009),
// row by row at first, then three rounds more. Alone that favours what is smooth; so a source counts the
// more, the more its level is overused beside the neighbours by the matrix `wanted`. The field's levels
// follow. `sections`: the source's, kNoLevel where it may not be used.
std::vector<std::uint32_t> patch_sources(const Image& source, const std::vector<LevelField>& sections,
                                         const ColorLevels&, const Cooccurrence& wanted, bool periodic,
                                         std::uint64_t seed, LevelField& field, const Work& = {});

}  // namespace terrazzo::cooccurrence_synth

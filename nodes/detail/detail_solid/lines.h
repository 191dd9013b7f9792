// Long thin structures: cracks and veins of the material, and scratches of the picture.
#pragma once

#include "nodes/data/detail.h"
#include "nodes/data/labels.h"
#include "nodes/detail/detail_solid/phases.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// Finds lines in the middle of the first section, at most 1,024 pixels square, measures them and takes their
// pixels out of the phases.
// - Scratches are lines of the binder that are straight over at least 24 pixels.
// - All other lines are sheets of their phase, of whichever sign makes more of them. A binder with scratches
//   has none, because short pieces of scratches look like them.
// Within 8 pixels of an outline, only lines that cross it count; others are rims. Each profile gets its own
// density. `noise`: what was taken out of the photograph's lightness before, sRGB-encoded; empty: nothing.
// Where it was taken out, it left patterns of its own.
void split_lines(Phases&, const Labels&, const std::vector<float>& noise, Detail&, std::uint64_t seed,
                 const Work& = {});

}  // namespace terrazzo::detail_solid

// A solid tile of each phase's detail.
#pragma once

#include <vector>

#include "nodes/detail/detail_solid/fill.h"
#include "nodes/detail/detail_solid/phases.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// The part of the photograph that shows most of a phase, at most `side` pixels square, completed where it
// shows something else. Offsets are shifted so that their mean is that of the phase in the whole photograph.
// Empty if the phase has too few pixels for a texture, or the photograph fewer than 16 per side.
PartialPicture phase_exemplar(const Phases&, int phase, int side, std::uint64_t seed, const Work& = {});

// Gives a tile the values of the phase's offsets in the whole photograph: their distribution along each of
// their principal axes. `offset` are all offsets of the photograph.
void match_phase(std::vector<Vec3f>& tile, const Phases&, const std::vector<Vec3f>& offset, int phase,
                 const Work& = {});

// A tileable solid of size³ voxels, x fastest, whose slices look like the exemplar. Zero if the exemplar is
// empty, and its mean if it has no contrast.
std::vector<Vec3f> phase_tile(const PartialPicture& exemplar, int size, std::uint64_t seed, const Work& = {});

}  // namespace terrazzo::detail_solid

// How often each pattern of 3 × 3 pixels occurs.
#pragma once

#include <array>
#include <vector>

#include "nodes/media/micrograph/phase_map.h"
#include "runtime/work.h"

namespace terrazzo::annealing {

constexpr int kPatterns = 512;

// Bit 3·column + row of a pattern tells whether that pixel is in the phase; rows run upwards in the picture.
using Frequencies = std::array<double, kPatterns>;

// Frequencies of the patterns of one phase whose pixels are `spacing` apart, at all places where all nine are
// observed. `turned`: the mean over the eight rotations and reflections. Empty places give zeros.
Frequencies pattern_frequencies(const media::PhaseMap&, int phase, int spacing, bool turned);

}  // namespace terrazzo::annealing

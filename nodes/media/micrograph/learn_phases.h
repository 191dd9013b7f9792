// The phases of a micrograph by example.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/strokes.h"
#include "nodes/media/micrograph/find_phases.h"

namespace terrazzo::media {

// Peak memory in bytes, with unobserved_pixels.
double learn_forecast(const Image&);

// Phase k is what looks like strokes[k], by a PixelForest, whose votes a Markov random field smooths as in
// find_phases(). Pixels under a stroke have its phase, that of the last one if strokes overlap. Throws Error
// "no-strokes", "wrong-count" (fewer than two phases, or more than kMostPhases), "bad-pixels", "empty-image".
FoundPhases learn_phases(const Image&, const std::vector<std::uint8_t>& unobserved,
                         const std::vector<const Strokes*>& strokes, double smoothing, std::uint64_t seed,
                         const Work&);

}  // namespace terrazzo::media

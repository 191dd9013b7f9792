// The profiles of another photograph that could have been taken.
#pragma once

#include <cstdint>

#include "nodes/data/profiles.h"

namespace terrazzo::resample_profiles {

// Draw 0 is the photograph itself. In every other one, each profile appears a Poisson number of times with
// mean 1, and the binder between them keeps its area: the observed area, and with it the area fraction,
// follow the profiles. From ten sections on, whole sections are drawn instead. Equal seeds and draws give
// equal bits. Throws Error "no-profiles".
Profiles resample(const Profiles&, int draw, std::uint64_t seed);

}  // namespace terrazzo::resample_profiles

// Particles as instances of their shapes, common to the formats that store them so.
#pragma once

#include <cstddef>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo::exporting {

// For each shape the indices of its particles, ascending. Voids are omitted: they have no matter. Throws
// Error "no-particles" (none, or only voids), "no-such-shape", "bad-number" (NaN, infinity, a zero
// quaternion).
std::vector<std::vector<std::size_t>> instances_of(const Particles&, const Shapes&);

}  // namespace terrazzo::exporting

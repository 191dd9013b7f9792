// Seeds of round cells: the centers of packed spheres.
#pragma once

#include <cstdint>

#include "nodes/packing/cells/power_diagram.h"

namespace terrazzo::tessellation {

// Packs spheres whose volumes are proportional to `volume` and fill `fraction` of the box, at most about 0.6.
// Position and squared radius of each become a seed, so that the cell of a sphere holds at least what is
// nearest to it. The lower the fraction, the less regular are the cells.
Seeds sphere_seeds(const Vec3& box, const std::vector<double>& volume, std::uint64_t seed,
                   double fraction = 0.55, const Work& work = {});

}  // namespace terrazzo::tessellation

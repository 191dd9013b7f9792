// Seeds of round cells: the centers of packed spheres.
#pragma once

#include <cstdint>

#include "nodes/tessellation/power_diagram.h"

namespace terrazzo::tessellation {

// Packs spheres whose volumes are proportional to `volume` and fill about half the box. Position and squared
// radius of each become a seed, so that the cell of a sphere holds at least what is nearest to it.
Seeds sphere_seeds(const Vec3& box, const std::vector<double>& volume, std::uint64_t seed,
                   const Work& work = {});

}  // namespace terrazzo::tessellation

// Particles whose color is too rare, or too close to the binder's, to form a cluster.
#pragma once

#include <vector>

#include "nodes/photograph/segment/color/figure_ground.h"
#include "nodes/photograph/segment/color/mosaic.h"

namespace terrazzo::segment {

// Marks patches that stand out from the binder as particles. A patch stands out if its distance to the
// typical color (median) of every binder cluster exceeds four times that cluster's median deviation, four
// times the image's usual contrast, and 0.3 times its spread. Connected patches become a particle if their
// area is at least min_area, their solidity is above 0.7, they have an edge all around (their full color
// difference occurs within six pixels), and at most 0.4 of their outline borders particles found before,
// which excludes mere rims. Patches that stand out half as far join if most of their outline borders added
// patches.
void add_odd_bodies(const Mosaic&, const Ground&, double min_area, std::vector<bool>& patch_is_particle,
                    const Work&);

}  // namespace terrazzo::segment

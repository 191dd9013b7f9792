// Particles of a colour so rare, or so near the binder's, that no cluster is theirs.
#pragma once

#include <vector>

#include "nodes/segment/figure_ground.h"
#include "nodes/segment/regions.h"

namespace terrazzo {

// Marks as particles the patches of the binder that stand out from it: further from the usual colour (median)
// of every binder cluster than four times that cluster's median deviation, four times the picture's usual
// contrast and three tenths of its spread, or half as far where most of their outline lies along such;
// together at least min_area large and of solidity above .7; with an edge all around, which is where the
// whole difference is crossed within six pixels; and not mere rims: no more than two fifths of their outline
// may lie along particles found before.
void add_odd_bodies(const Mosaic&, const Ground&, double min_area, std::vector<bool>& patch_is_particle,
                    const Work&);

}  // namespace terrazzo

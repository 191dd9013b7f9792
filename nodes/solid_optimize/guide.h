// What else than colour patches are matched by, so that lines stay lines.
#pragma once

#include <vector>

#include "nodes/solid_optimize/exemplar_levels.h"

namespace terrazzo::solid_optimize {

// Gives each exemplar a `guide`: its pixels' signed distances to the border between dark and light (Otsu
// 1979, one threshold for all, of the first channel of `working`), up to `reach` pixels, of standard
// deviation `weight` over all. Averages of patches that disagree move such a border; averages of colours
// dissolve thin veins and joints (feature maps: Kopf et al. 2007, 4; Wu and Yu 2004). Of Oklab's axes the
// first is lightness in nearly all materials.
void guide_by_phases(std::vector<SolidExemplar>& working, double weight, int reach);

}  // namespace terrazzo::solid_optimize

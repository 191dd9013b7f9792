// A guidance channel for patch matching that keeps lines intact.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/exemplar/exemplar_levels.h"

namespace terrazzo::solids {

// Sets each exemplar's `guide`: each pixel's signed distance to the border between dark and light, clamped to
// `reach` pixels and scaled to standard deviation `weight` over all exemplars. One threshold for all (Otsu
// 1979) splits the first channel of `working`, which is lightness for nearly all materials in Oklab.
// Averaging patches that disagree moves the border, while averaging colors dissolves thin veins and joints
// (feature maps: Kopf et al. 2007, section 4; Wu and Yu 2004).
void guide_by_phases(std::vector<SolidExemplar>& working, double weight, int reach);

}  // namespace terrazzo::solids

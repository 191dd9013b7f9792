// Measures of how closely sections of the solid match the exemplar.
#pragma once

#include <array>
#include <vector>

#include "nodes/solids/synthesis/options/solid_options.h"
#include "nodes/solids/synthesis/whole/result.h"

namespace terrazzo::solids {

// One entry per family, with the values computed from the final matches: copied and copied_worst.
std::vector<PlaneMeasures> measure_copies(const std::vector<NeighborField>&, const Work&);
// All other measures. `working` are the exemplars in the field's axes. A block has no seam, and only one
// band: the first of finest_bands.
void measure_planes(const std::vector<SolidExemplar>& working, const SolidOptions&, const SolidField&,
                    std::vector<PlaneMeasures>&, const Work&);
// (λ₁ − λ₂)/(λ₁ + λ₂) of the structure tensor of a picture. 0: no direction; 1: stripes.
double directedness(const SolidExemplar& working);
// Fraction of the variance that remains when details under 1/8 of the picture's side are averaged away.
double coarseness(const SolidExemplar& working);

}  // namespace terrazzo::solids

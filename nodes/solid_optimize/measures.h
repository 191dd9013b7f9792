// How much sections of the solid look like the exemplar.
#pragma once

#include <array>
#include <vector>

#include "nodes/solid_optimize/solid_optimize.h"

namespace terrazzo::solid_optimize {

// One entry a family, with what the final matches tell: copied and copied_worst.
std::vector<PlaneMeasures> measure_copies(const std::vector<MatchFamily>&);
// All else. `working` are the exemplars in the field's axes. Of a block there is no seam, and one band: the
// first of finest_bands.
void measure_planes(const std::vector<SolidExemplar>& working, const SolidSettings&, const SolidField&,
                    std::vector<PlaneMeasures>&, const Work&);
// Of a picture's squared gradients: (λ₁ − λ₂)/(λ₁ + λ₂) of the structure tensor. 0: no direction; 1: stripes.
double directedness(const SolidExemplar& working);
// Share of the variance that is left when details under 1/8 of the picture's side are averaged away.
double coarseness(const SolidExemplar& working);

}  // namespace terrazzo::solid_optimize

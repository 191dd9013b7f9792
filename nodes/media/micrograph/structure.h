// Direction and size of the structures in a picture of phases.
#pragma once

#include "nodes/media/micrograph/phase_map.h"

namespace terrazzo::media {

// (λ₁ − λ₂)/(λ₁ + λ₂) of the structure tensor. 0: no direction; 1: stripes.
double directedness(const PhaseMap&);

// Distance in pixels at which the covariance of the phases, summed, falls to 1/e of their variance; an
// eighth of the shorter side if it does not before. The middle 2,048 pixels along each side count.
double correlation_length(const PhaseMap&);

}  // namespace terrazzo::media

// Two zones of the binder, such as mastic and air in asphalt.
#pragma once

#include <cstdint>

#include "nodes/data/detail.h"
#include "nodes/data/labels.h"
#include "nodes/detail/detail_solid/phases.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// If the binder's lightness has two separate levels (Otsu 1979: they explain at least 0.77 of its variance;
// 0.64 for a normal and 0.75 for a uniform distribution) in zones of more than a few pixels, takes the level
// of each pixel's zone out of `phases.offset`, stores a model of the zones in the detail and their numbers
// (1: dark, 2: light) in `phases.zone`. Pixels between zones are not used any more if enough others are left.
//
// The model is a Gaussian field that is cut at a level. In pictures it depends on how wide the binder is
// there, so that air fills wide gaps and mastic narrow ones as in the photograph; where only the distance
// from the nearest outline is known, on this. The field's covariance is fitted to how often two pixels are
// both dark, by distance (Quiblier 1984).
void split_zones(Phases&, const Labels&, Detail&, std::uint64_t seed, const Work& = {});

// Divides the offsets by their median deviation in each zone relative to the stronger one, and stores these.
// Pixels of a zone with less than 0.3 of the other's, such as air, are not used any more if the other has
// 4,000.
void split_zone_contrasts(Phases&, Detail&);

}  // namespace terrazzo::detail_solid

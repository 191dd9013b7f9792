// How the photograph's light falls on profiles: what depends on a direction in the picture.
#pragma once

#include "nodes/data/detail.h"
#include "nodes/data/labels.h"
#include "nodes/detail/detail_solid/phases.h"

namespace terrazzo::detail_solid {

// The mean slope of lightness across the profiles of each group, and what the offsets of each phase owe to
// the direction of the nearest outline's normal, by distance from it and by the size of its profile. Both are
// subtracted from `phases.offset` and stored in the detail, whose rims must be there. Each is shrunk by what
// may be chance, since the profiles differ (James and Stein 1961), so that pictures without light from one
// side have none.
void split_light(Phases&, const Labels&, Detail&);

}  // namespace terrazzo::detail_solid

// How strong grain and broad variation are in each profile.
#pragma once

#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/detail/detail_solid/phases.h"
#include "runtime/work.h"

namespace terrazzo::detail_solid {

// Deviations of each profile's grain and of its broad part relative to its group's, of gray and of chroma.
// Divides both by them and stores them with the profile's color in the detail: stones with strong zones need
// not have strong grain. `image`: the photograph. Small profiles are left as they are, contrasts from few
// pixels are moved towards those of the group, and pixels within 2.5 pixels of an outline do not count.
// Contrasts of chroma that exceed the others of their group by far are limited.
void split_contrasts(Phases&, const Image&, const Labels&, Detail&, const Work& = {});

}  // namespace terrazzo::detail_solid

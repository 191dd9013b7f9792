// What depends on the place within a particle: rims along outlines, slopes across particles, and how soft
// outlines are.
#pragma once

#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/detail/detail_solid/phases.h"

namespace terrazzo::detail_solid {

// Mean offsets of each phase by distance from the nearest outline and by the size of the profile that has it,
// subtracted from `phases.offset` and stored in the detail, which must have the phases and the pixel size.
void split_rims(Phases&, const Labels&, Detail&);

// Deviations of the offsets by distance from the nearest outline, relative to that of the phase. Divides the
// offsets by them and stores them in the detail. In particles, stores those of the grain besides, from pixels
// and their four neighbors, which the blur of outlines hardly enters; split_contrasts divides the grain by
// them.
void split_gains(Phases&, const Labels&, Detail&);

// Deviations of each profile's grain and of its broad part relative to its group's, of gray and of chroma.
// Divides both by them and stores them with the profile's color in the detail: stones with strong zones need
// not have strong grain. `image`: the photograph. Small profiles are left as they are, contrasts from few
// pixels are moved towards those of the group, and pixels within 2.5 pixels of an outline do not count.
// Contrasts of chroma that exceed the others of their group by far are limited.
void split_contrasts(Phases&, const Image&, const Labels&, Detail&, const Work& = {});

// Leaves out what is close to outlines, where blur, sharpening and compression change the grain: of each
// phase, the pixels within as many as 4 pixels of an outline, as long as 4,000 others remain.
void keep_deep_pixels(Phases&, const Labels&);

// Fits to each profile a plane in lightness, subtracts it and returns, for each group, the standard deviation
// along an axis of the slope times the profile's radius √(A/π). A slope counts as at most twice the group's
// median by area. Small profiles are left as they are.
std::vector<double> split_slopes(Phases&, const Labels&);

// Standard deviation in pixels of the blur of outlines between particles and binder, at most 3: from the
// distance over which the mean step from one flat color to the other rises from 1/4 to 3/4, less the width of
// a pixel.
double outline_softness(const Image&, const Labels&);

}  // namespace terrazzo::detail_solid

// What depends on the place within a particle: rims along outlines and slopes across particles.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "nodes/data/detail.h"
#include "nodes/data/labels.h"
#include "nodes/detail/detail_solid/phases.h"

namespace terrazzo::detail_solid {

// Distance of each pixel from the nearest outline, in pixels, and its bin among n.
inline std::vector<float> depths_of(const Phases& p, const Labels& labels) {
  return outlines_of(p, labels).depth;
}
inline std::size_t bin_of(float depth, std::size_t n) { return std::min<std::size_t>(depth, n - 1); }

// Mean offsets of each phase by distance from the nearest outline and by the size of the profile that has it,
// subtracted from `phases.offset` and stored in the detail, which must have the phases and the pixel size.
void split_rims(Phases&, const Labels&, Detail&);

// Deviations of the offsets by distance from the nearest outline, relative to that of the phase. Divides the
// offsets by them and stores them in the detail. In particles, stores those of the grain besides, from pixels
// and their four neighbors, which the blur of outlines hardly enters; split_contrasts divides the grain by
// them.
void split_gains(Phases&, const Labels&, Detail&);

// Leaves out what is close to outlines, where blur, sharpening and compression change the grain: of each
// phase, the pixels within as many as 4 pixels of an outline, as long as 4,000 others remain.
void keep_deep_pixels(Phases&, const Labels&);

// Fits to each profile a plane in lightness, subtracts it and returns, for each group, the standard deviation
// along an axis of the slope times the profile's radius √(A/π). A slope counts as at most twice the group's
// median by area. Small profiles are left as they are.
std::vector<double> split_slopes(Phases&, const Labels&);

}  // namespace terrazzo::detail_solid

// Particles of two colors that were found as one.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/segment/color/lab_image.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// Splits a particle, such as a pore and the grain at its side, whose colors form two groups that explain at
// least 0.85 of their variance (Otsu 1979, along the main axis of color). A part of the smaller group becomes
// a particle of its own if it has at least 40 pixels and 0.03 of the particle's area, and if at most 0.35 of
// its outline borders the rest, so veins, spots and rims stay. `labels` are those of one section, row by row,
// 0: binder; new particles are numbered from `next` on. Returns the former label of each.
std::vector<std::int32_t> split_two_materials(const LabImage& patch_colors, std::vector<std::int32_t>& labels,
                                              std::int32_t next, const Work&);

}  // namespace terrazzo::segment

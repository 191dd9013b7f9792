// Binder between particles whose labels touch.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/photograph/segment/color/lab_image.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// Gives pixels of touching particles back to the binder. A network leaves no binder between neighbors that
// are only a few pixels apart. A pixel within three pixels of another particle becomes binder if its color is
// closer to that of the binder than to that of its own particle, both nearby. Where these two differ by less
// than four times the noise or twice the texture, or where no binder is known, pixels stay. So do groups of
// fewer than five pixels within a particle, and particles that would lose more than half of their pixels.
//
// `patch_colors` (mosaic.h), `labels` (0: binder) and `coverage` are those of one section, row by row.
// Coverage is ≥ ½ exactly where the label is not 0.
void open_contacts(const Image&, int section, const LabImage& patch_colors, std::vector<std::int32_t>& labels,
                   std::vector<float>& coverage, const Work&);

}  // namespace terrazzo::segment

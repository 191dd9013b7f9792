// Outlines of particles whose texture makes the outline ragged.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/photograph/segment/color/lab_image.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// Where texture or noise is more than a tenth of the contrast between a particle and the binder around it,
// single pixels do not tell on which side of the outline they are. The outlines of such particles are
// smoothed: the mask is blurred, and the level that keeps the particle's area becomes the outline. The blur
// grows with texture / contrast up to 1.5 pixels, or 0.03 √area if that is more, but stays below 0.12 √area,
// so that small particles keep their shape. The other particles keep all their pixels.
//
// `patch_colors` (mosaic.h), `labels` (0: binder) and `coverage` are those of one section, row by row.
// Coverage is ≥ ½ exactly where the label is not 0.
void smooth_outlines(const LabImage& patch_colors, std::vector<std::int32_t>& labels,
                     std::vector<float>& coverage, const Work&);

}  // namespace terrazzo::segment

// Sub-pixel outlines of labeled particles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::segment {

struct LabelOutline {
  std::vector<Vec2> points;  // pixels, y up from the lower left corner of the image, counterclockwise, first
                             // point not repeated
  double area = 0;           // pixels, of all loops of the label, minus holes
  Vec2 centroid = Vec2::Zero();  // of all loops, pixels, y up
};

// For each of `count` ids from `first` in `labels`: the ½ level of `coverage` by marching squares (Lorensen
// and Cline 1987, in two dimensions), where other labels count as 0. Diagonal neighbors with the same label
// are joined. `points` is the loop with the largest area; an id without pixels has an empty outline.
std::vector<LabelOutline> outlines(std::span<const std::int32_t> labels, std::span<const float> coverage,
                                   int width, int height, int count, const Work&, std::int32_t first = 1);

}  // namespace terrazzo::segment

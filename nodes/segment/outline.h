// Outlines of labelled particles at sub-pixel accuracy.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/work.h"

namespace terrazzo {

struct LabelOutline {
  std::vector<Vec2>
      points;       // pixels, y up from the lower left corner of the picture, counter-clockwise, not repeated
  double area = 0;  // pixels, of all loops of the label, holes subtracted
  Vec2 centroid = Vec2::Zero();  // of all loops, pixels, y up
};

// For each id from 1 to `count` in `labels`: the ½ level of bilinear cells (marching squares, Lorensen and
// Cline 1987 in two dimensions) of the covered share inside the label, of what the binder pixels around
// share, and of 0 beyond. Diagonal neighbours of one label are joined. `points` is the longest loop; ids
// without pixels give an empty outline.
std::vector<LabelOutline> outlines(const std::vector<std::int32_t>& labels,
                                   const std::vector<float>& coverage, int width, int height, int count,
                                   const Work&);

}  // namespace terrazzo

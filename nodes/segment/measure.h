// What is measured of labelled particles.
#pragma once

#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo {

// Profiles of all sections: areas and outlines (mm, y up) from `coverage` (per pixel of the stack; see
// coverage.h), mean colours over the pixels that lie inside by more than a pixel where there are any, border
// marks and weights. A profile that touches the border (its label holds a pixel of the outermost rows or
// columns) has weight 0; any other, of w × h pixels, can lie whole in (W − w − 1)(H − h − 1) places of the W
// × H that its corner can take, and weighs the inverse (Miles 1974; Lantuéjoul 1980).
Profiles measure_profiles(const Image&, const Labels&, const std::vector<float>& coverage, const Work&);

}  // namespace terrazzo

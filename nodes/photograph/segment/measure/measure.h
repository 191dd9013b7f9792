// Measurement of labeled particles.
#pragma once

#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "nodes/photograph/marks/ignored.h"
#include "runtime/work.h"

namespace terrazzo::segment {

// Profiles of all sections: areas and outlines (mm, y up) from `coverage` (per pixel of the stack, see
// coverage.h), border flags, weights, and median colors of the pixels more than one pixel inside, if there
// are any. A profile touches the border if its label includes a pixel of the outermost rows or columns; its
// weight is then 0. Any other profile of w × h pixels fits completely at (W − w − 1)(H − h − 1) of the W × H
// positions of its corner, and its weight is the inverse of that share (Miles 1974; Lantuéjoul 1980).
// Ignored pixels count as outside: they are not observed, and a profile whose box, with a rim of
// one pixel, contains any of them has no weight. Undecided pixels are not observed either, but cut no
// profile; connected ones are fragments.
Profiles measure_profiles(const Image&, const Labels&, const std::vector<float>& coverage,
                          const IgnoredPixels&, const UndecidedPixels&, const Work&);

}  // namespace terrazzo::segment

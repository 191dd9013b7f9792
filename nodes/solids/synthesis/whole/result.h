// A synthesized solid, or one block of it, and its measures.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/exemplar/colors.h"
#include "nodes/solids/synthesis/matching/blend.h"

namespace terrazzo::solids {

// Measures over all slices across one axis; names with "worst" are of a single slice.
struct PlaneMeasures {
  int axis = 0;
  double histogram = 0;  // mean over quantiles of |Q_s − Q_e|, averaged over the channels
  double patches = 0;    // sliced Wasserstein distance of 7 × 7 patches, root mean square of three scales
  double patches_floor = 0;   // the same between two halves of the exemplar
  double seam = 1;            // gradient across the wrap along this axis / inside
  double copied = 0;          // fraction of neighboring matches that are also neighbors in the exemplar
  double copied_worst = 0;    // of the slice where it is largest
  double stripes_worst = 1;   // factor by which squared gradients along columns and rows are more
                              // one-directional than the exemplar's, for the most striped slice
  std::vector<double> bands;  // per scale (high-pass, scales, low-pass): σ of the slices' bands / the
                              // exemplar's, root mean square over orientations and channels
};

struct SolidResult {
  Vec3i size = Vec3i::Zero();    // of the field: the whole solid or the block
  Vec3i origin = Vec3i::Zero();  // of the field in the solid
  ColorAxes axes;
  SolidField field;      // in the working axes
  BlendSources sources;  // of the last blend, before the finish
  int levels = 0;
  std::vector<PlaneMeasures> measures;  // one per constrained axis
};

}  // namespace terrazzo::solids

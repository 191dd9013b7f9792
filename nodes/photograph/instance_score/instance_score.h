// Comparison of found particles with masks drawn by hand.
#pragma once

#include <vector>

#include "nodes/data/labels.h"
#include "runtime/work.h"

namespace terrazzo::instance_score {

// Intersection over union of a found particle and a mask.
struct Match {
  std::int32_t found = 0, mask = 0;  // ids
  double overlap = 0;                // 0 to 1
};

struct Score {
  std::vector<Match> matches;  // pairs that overlap by at least ½, by mask
  int found = 0, masks = 0;
  double found_area = 0, mask_area = 0;  // fractions of the pixels

  int matched(double overlap) const;  // pairs that overlap by at least this much, ½ or more
  // Average precision of instance segmentation: matched / (matched + false positives + missed), as the
  // segmentation of cells defines it (Stringer et al. 2021). 1 if both are empty.
  double average_precision(double overlap) const;
  double recall(double overlap) const;
};

// Two regions that overlap by more than half of their union match nobody else, so the pairs are unique; of
// pairs with exactly half, the first in order of masks counts. Particles without pixels are not counted.
// Throws Error "size-mismatch".
Score compare_instances(const Labels& found, const Labels& masks);

}  // namespace terrazzo::instance_score

// Restores detail that optimization blurs, with filters of finite reach.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/blockwise/passes.h"
#include "nodes/solids/synthesis/exemplar/finest_bands.h"

namespace terrazzo::solids {

// The finish of a part of a level. A round maps the bands of the slices across each family's axis to their
// exemplar's distribution and adds up the changes of all planes, times 2/3 if there are three; then it maps
// the values.
struct BlockFinish {
  const std::vector<std::vector<std::vector<Quantiles>>>& bands;  // wanted: [exemplar][channel][band]
  const std::vector<TorusBox>& boxes;  // per round; the input must be valid kFinishReach further out
  // The maps of each round, [channel][round]. If `measured` is set, they are fixed from the values in that
  // box and from those wanted there, per channel; otherwise they are given.
  std::vector<std::vector<FinishMaps>>& maps;
  const TorusBox* measured;
  const std::vector<Quantiles>& values;
};

// Runs all rounds on all channels.
void finish_region(const BlockFinish&, BlockRegion&, const Work&);

}  // namespace terrazzo::solids

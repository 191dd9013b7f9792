// Restores detail that optimization blurs, with filters of finite reach.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/blockwise/passes.h"
#include "nodes/solids/synthesis/exemplar/finest_bands.h"

namespace terrazzo::solids {

// One round on one channel, in `box`; the stored input must be valid kFinishReach further out. Maps the bands
// of the slices across each family's axis to their exemplar's distribution and adds up the changes of all
// planes, times 2/3 if there are three; then maps the values to `values`. If `measured` is set, the maps are
// fixed from the values in that box, otherwise taken from `maps`.
void finish_round(const std::vector<std::vector<std::vector<Quantiles>>>& wanted, const Quantiles& values,
                  int channel, const TorusBox& box, const TorusBox* measured, FinishMaps& maps, BlockRegion&,
                  const Work&);

}  // namespace terrazzo::solids

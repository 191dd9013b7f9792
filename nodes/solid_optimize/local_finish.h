// Restores detail that optimization blurs, with filters of finite reach.
#pragma once

#include <vector>

#include "nodes/solid_optimize/local_passes.h"

namespace terrazzo::solid_optimize {

constexpr int kFinishBands = 4;
constexpr int kFinishReach = 9;   // voxels around itself that a round reads
constexpr int kFinishLeast = 24;  // shortest side of an exemplar; leaves 6 × 6 pixels to measure

// The finest bands of a picture: the picture minus itself smoothed along rows; that minus itself smoothed
// along columns too; and the smoothed picture split likewise by the same filter with gaps of one pixel (an
// à-trous transform; Holschneider et al. 1989). Details across and along rows are kept apart, because
// otherwise layers turn into stripes. Returns quantiles per channel and band, without a margin of
// kFinishReach.
std::vector<std::vector<Quantiles>> finest_bands(const SolidExemplar& working, int channels);

// Root mean square of the first two bands together over all channels. The picture must have at least 7 × 7
// pixels.
double finest_deviation(const SolidExemplar& working, int channels);

// One round on one channel, in `box`; the stored input must be valid kFinishReach further out. Maps the bands
// of the slices across each family's axis to their exemplar's distribution and adds up the changes of all
// planes, times 2/3 if there are three; then maps the values to `values`. If `measured` is set, the maps are
// fixed from the values in that box, otherwise taken from `maps`.
void finish_round(const std::vector<std::vector<std::vector<Quantiles>>>& wanted, const Quantiles& values,
                  int channel, const LocalBox& box, const LocalBox* measured, FinishMaps& maps, LocalRegion&,
                  const Work&);

}  // namespace terrazzo::solid_optimize

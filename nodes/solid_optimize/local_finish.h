// What optimization blurs, given back by filters of finite reach.
#pragma once

#include <vector>

#include "nodes/solid_optimize/local_passes.h"

namespace terrazzo::solid_optimize {

constexpr int kFinishBands = 4;
constexpr int kFinishReach = 9;   // voxels that a round looks about itself
constexpr int kFinishLeast = 24;  // pixels of an exemplar's side, which leave 6 × 6 to measure

// The finest bands of a picture: it less itself smoothed along rows, that less itself smoothed along columns
// too, and the smoothed one likewise by the same filter with gaps of a pixel (an à-trous transform;
// Holschneider et al. 1989). Details across and along rows apart, or layers come out as stripes. Per channel
// and band, all but a margin of kFinishReach.
std::vector<std::vector<Quantiles>> finest_bands(const SolidExemplar& working, int channels);

// Root of the mean square of the first two together over all channels, of a picture of 7 × 7 or more.
double finest_deviation(const SolidExemplar& working, int channels);

// One round on one channel, in `box`; what is stored is right kFinishReach further out. The bands of the
// slices across each family's axis are given their exemplar's distribution, and what the planes want changed
// is added up, two thirds of it where there are three; then the values theirs. Where `measured` holds a box
// the maps are fixed by what lies in it, else they are taken from `maps`.
void finish_round(const std::vector<std::vector<std::vector<Quantiles>>>& wanted, const Quantiles& values,
                  int channel, const LocalBox& box, const LocalBox* measured, FinishMaps& maps, LocalRegion&,
                  const Work&);

}  // namespace terrazzo::solid_optimize

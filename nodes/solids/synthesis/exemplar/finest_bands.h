// The finest bands of a picture that need not tile, by filters of finite reach.
#pragma once

#include <array>
#include <vector>

#include "nodes/common/texture/quantiles.h"
#include "nodes/solids/synthesis/exemplar/exemplar_levels.h"

namespace terrazzo::solids {

constexpr int kFinishBands = 4;
constexpr int kFinishReach = 9;   // voxels around itself that a round reads
constexpr int kFinishLeast = 24;  // shortest side of an exemplar; leaves 6 × 6 pixels to measure

// The bands of a picture of width × height, without a margin of kFinishReach.
struct FinestBands {
  std::vector<float> picture, rows, once, rows_again, twice;
  std::array<std::vector<float>, kFinishBands> band;

  void split(int width, int height);
};

// The finest bands of a picture: the picture minus itself smoothed along rows; that minus itself smoothed
// along columns too; and the smoothed picture split likewise by the same filter with gaps of one pixel (an
// à-trous transform; Holschneider et al. 1989). Details across and along rows are kept apart, because
// otherwise layers turn into stripes. Returns quantiles per channel and band, without a margin of
// kFinishReach.
std::vector<std::vector<Quantiles>> finest_bands(const SolidExemplar& working, int channels);

// Root mean square of the first two bands together over all channels. The picture must have at least 7 × 7
// pixels.
double finest_deviation(const SolidExemplar& working, int channels);

}  // namespace terrazzo::solids

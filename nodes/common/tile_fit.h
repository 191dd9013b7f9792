// How often a tile is laid along an edge that it must fill a whole number of times.
#pragma once

#include <algorithm>
#include <cmath>

namespace terrazzo {

struct TileFit {
  int periods = 1;
  double scale = 1;  // of the tile as laid, over its own
};

// Of the two whole numbers around edge / period the one whose scale is nearer to 1, as a ratio; both above 0.
inline TileFit fit_tile(double edge, double period) {
  const double exact = std::clamp(edge / period, 1.0, 1e6), m = std::floor(exact);
  TileFit fit;
  fit.periods = static_cast<int>(exact * exact > m * (m + 1) ? m + 1 : m);
  fit.scale = edge / (fit.periods * period);
  return fit;
}

}  // namespace terrazzo

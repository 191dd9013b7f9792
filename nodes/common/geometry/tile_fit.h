// Number of periods of a tile along an edge that they must fill exactly.
#pragma once

#include <algorithm>
#include <cmath>

namespace terrazzo {

struct TileFit {
  int periods = 1;
  double scale = 1;  // of the placed tile relative to the original
};

// Chooses between the two whole numbers around edge / period the one whose scale is closer to 1 as a ratio.
// Both arguments must be above 0.
inline TileFit fit_tile(double edge, double period) {
  const double exact = std::clamp(edge / period, 1.0, 1e6), m = std::floor(exact);
  TileFit fit;
  fit.periods = static_cast<int>(exact * exact > m * (m + 1) ? m + 1 : m);
  fit.scale = edge / (fit.periods * period);
  return fit;
}

}  // namespace terrazzo

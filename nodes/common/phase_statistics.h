// How the darker half of a picture lies: two-point correlation and lineal path (Torquato 2002, 2.1 and 2.4).
#pragma once

#include <cstdint>
#include <vector>

namespace terrazzo {

// One picture's phase, 1 where it is; x fastest.
struct Phase {
  int width = 0, height = 0;
  std::vector<std::uint8_t> in;
};

struct PhaseStatistics {
  std::vector<double> two_point;    // S2(r), r = 0 … reach: both ends of a segment of r pixels in the phase
  std::vector<double> lineal_path;  // L(r): all of it in the phase
};

// Along x and y alike, over all pictures; reach must be below every side.
PhaseStatistics phase_statistics(const std::vector<Phase>&, int reach);

}  // namespace terrazzo

// Two-point correlation, lineal path and cluster function of a phase in images (Torquato 2002, 2.1, 2.4 and
// 2.5).
#pragma once

#include <cstdint>
#include <vector>

namespace terrazzo {

// The phase in one image: 1 inside, 0 outside, 2 not observed; x fastest.
struct Phase {
  int width = 0, height = 0;
  std::vector<std::uint8_t> in;
};

struct PhaseStatistics {
  std::vector<double> two_point;  // S2(r), r = 0 … reach: probability that both ends of a segment of r pixels
                                  // are in the phase
  std::vector<double> lineal_path;  // L(r): probability that the whole segment is in the phase
};

// Averages over segments along x and along y in all images whose pixels are observed. `reach` must be below
// every side.
PhaseStatistics phase_statistics(const std::vector<Phase>&, int reach);

// C2(r): probability that both ends of such a segment are in one piece of the phase, connected by edges of
// pixels within the image.
std::vector<double> cluster_function(const std::vector<Phase>&, int reach);

}  // namespace terrazzo

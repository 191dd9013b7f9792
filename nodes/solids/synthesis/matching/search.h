// The search for the best match of each patch.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/solids/synthesis/matching/matches.h"

namespace terrazzo::solids {

// Colors in the working axes, one array per channel, x fastest.
struct SolidField {
  Vec3i size = Vec3i::Zero();
  std::vector<std::vector<float>> channel;
};

struct SearchOptions {
  float overuse = 1;  // penalty on patches used more often than average
  float copying = 1;  // penalty on patches that copy the exemplar layout of all four neighbors
  bool exhaustive = false;
  std::uint64_t seed = 1;
  int iteration = 0;  // selects the random draws and the direction of the sweep
};

// Improves the matches of all families. Each patch tries its previous match, those of its six neighbors (in
// its plane, shifted accordingly), patches similar to the best so far, and a shrinking random search (Barnes
// et al. 2009; Tong et al. 2002). The score is d²·(1 + overuse·(use/mean use − 1)), where the second term
// applies if use exceeds the mean, times 1 + copying · n/4 if the patch copies the exemplar layout of n of
// the four neighbors in its plane. Leaves squared distances in `weight`. The result has the same bits for any
// number of threads.
void search_matches(const SolidField&, const std::vector<const ExemplarLevel*>& exemplars,
                    std::vector<NeighborField>&, const SearchOptions&, const Work&);

// Reads a slice, with its first 7 columns and rows repeated after the last, channels interleaved.
void read_slice(const SolidField&, int axis, int slice, std::vector<float>& out);

}  // namespace terrazzo::solids

// The search for each patch's match.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/solid_optimize/matches.h"

namespace terrazzo::solid_optimize {

// Colours in the working axes, one array a channel, x fastest.
struct SolidField {
  Vec3i size = Vec3i::Zero();
  std::vector<std::vector<float>> channel;
};

struct SearchSettings {
  float overuse = 1;  // how much a patch in use more often than others counts as further
  float copying = 1;  // how much one that goes on from all four neighbours' as they lie in the exemplar does
  bool exhaustive = false;
  std::uint64_t seed = 1;
  int iteration = 0;  // tells the random draws and the direction of the sweep apart
};

// Improves the matches of all families: each patch tries the previous match, those of its six neighbours (in
// its plane, moved along), patches similar to the best so far, and a shrinking random search (Barnes et al.
// 2009; Tong et al. 2002). The score is d²·(1 + overuse·(use/mean use − 1)), where use is above the mean,
// times 1 + copying · n/4, where it goes on from n of the four neighbours in its plane. Leaves squared
// distances in `weight`. Equal bits for any number of threads.
void search_matches(const SolidField&, const std::vector<const ExemplarLevel*>& exemplars,
                    std::vector<MatchFamily>&, const SearchSettings&, const Work&);

// A slice with its first 7 columns and rows repeated after the last, channels interleaved.
void read_slice(const SolidField&, int axis, int slice, std::vector<float>& out);

}  // namespace terrazzo::solid_optimize

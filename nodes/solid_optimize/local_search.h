// The search for matches in a part of a level, from one copy into another.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/solid_optimize/local_box.h"
#include "nodes/solid_optimize/search.h"

namespace terrazzo::solid_optimize {

// A part of a level: its families hold the patches stored on `lines`, each slice of the part being one of
// theirs.
struct LocalRegion {
  LocalLines lines;
  std::vector<MatchFamily> families;
  SolidField field;
};

// What the draws of a patch come from, the same wherever it is asked for: by the finaliser "lowbias32"
// (Wellons 2018), which a shader can do as well.
inline std::uint32_t mix32(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}
std::uint32_t search_key(std::uint64_t seed, int iteration, int axis);

// A family of the patches on these lines, without matches.
MatchFamily local_family(const LocalLines&, int axis, int exemplar);

// One pass over the patches that cover any voxel of `box`, which reads all matches as they were before it.
// Candidates are those of search_matches, with neighbours one to three patches away. Leaves squared distances
// in the weights of those patches.
void search_locally(const std::vector<const ExemplarLevel*>& exemplars,
                    const std::vector<std::vector<float>>& penalty, const LocalBox& box,
                    const SearchSettings&, LocalRegion&, const Work&);

// Copies what is stored beyond the ends of closed axes from where it was made.
void copy_beyond(const LocalLines&, MatchFamily&, const Work&);
void copy_beyond(const LocalLines&, std::vector<float>& voxels, const Work&);

}  // namespace terrazzo::solid_optimize

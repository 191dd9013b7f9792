// The search for matches in a part of a level, from one copy of the matches into another.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/solids/synthesis/matching/search.h"
#include "nodes/solids/synthesis/matching/torus_box.h"

namespace terrazzo::solids {

// A part of a level. Its families hold the patches stored on `lines`; each slice of the part is a slice of a
// family.
struct BlockRegion {
  TorusLines lines;
  std::vector<NeighborField> families;
  SolidField field;
};

// Hash for a patch's random draws, so that they depend only on its place: the finalizer "lowbias32" (Wellons
// 2018), which a shader can compute too.
inline std::uint32_t mix32(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}
std::uint32_t search_key(std::uint64_t seed, int iteration, int axis);

// A family of the patches on these lines, without matches.
NeighborField block_family(const TorusLines&, int axis, int exemplar);

// One pass over the patches that cover any voxel of `box`. It reads all matches as they were before the pass.
// The candidates are those of search_matches, with neighbors one to three patches away. Leaves squared
// distances in the weights of those patches.
void search_locally(const std::vector<const ExemplarLevel*>& exemplars,
                    const std::vector<std::vector<float>>& penalty, const TorusBox& box, const SearchOptions&,
                    BlockRegion&, const Work&);

// Updates the copies beyond the ends of closed axes from their originals.
void copy_beyond(const TorusLines&, NeighborField&, const Work&);
void copy_beyond(const TorusLines&, std::vector<float>& voxels, const Work&);

}  // namespace terrazzo::solids

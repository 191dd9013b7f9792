// The patches of the two solids that fit each patch of the solid between them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "nodes/solids/patch_fill/patch_space.h"
#include "nodes/solids/patch_fill/torus.h"
#include "runtime/work.h"

namespace terrazzo::patch_fill {

struct Place {
  std::int16_t x = 0, y = 0, z = 0;
};

// One match per patch. Patches start at every second voxel, x fastest.
struct Matches {
  Vec3i patches = Vec3i::Zero();  // number along each axis
  std::vector<Place> at;          // where the matched patch starts in its solid
  std::vector<float> distance;    // squared, between descriptions
};

enum class Use : std::uint8_t {
  None,   // the solid has no weight in the patch
  Fixed,  // the patch is the solid's own
  Free,
};

struct MatchLevel {
  Torus<Vec3f> texture;         // working colors of the solid
  std::vector<float> features;  // of the patches that start at every voxel
  std::vector<Use> use;         // of each patch of the result
};

struct SearchOptions {
  double overuse = 1;
  int apart = 0;  // matches less than this from the patch's own place are not used, voxels along every axis
  std::uint64_t seed = 1;  // differs from search to search
};

// Free patches start with random matches, the others with the patch at their own place.
Matches first_matches(const MatchLevel&, std::uint64_t seed);
// Matches of the level below (half the resolution) at the same places.
Matches carry_up(const Matches& coarse, const Torus<Vec3f>& coarse_texture, const MatchLevel& fine);
// Improves the free matches: each patch tries its match, its neighbors' matches shifted accordingly, and
// random patches ever nearer to the best (Barnes et al. 2009). `wanted` describes the patches of the result.
// Each pass reads the matches of the pass before, so that the result does not depend on threads.
void improve(Matches&, const MatchLevel&, const std::vector<float>& wanted, int dimensions,
             const SearchOptions&, const Work&);

}  // namespace terrazzo::patch_fill

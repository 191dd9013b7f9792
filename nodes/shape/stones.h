// Stones of other characters than a crusher's, from a seed.
#pragma once

#include <cstdint>
#include <string>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo {

struct StoneOptions {
  std::string kind;  // see stone_mesh
  std::uint64_t seed = 1;
  std::uint64_t item = 0;  // which stone of the seed
  Vec3 axes = Vec3::Ones();
  int detail = 3;  // 20·4^detail triangles, 0…6
};

// "pebble": worn smooth, all but convex. "shard": longish (axes × (1.7, 1, 0.8)), rounded, with a few flat
// sides and the sharp edges between them. "clinker": lobed, hollowed and bent by half a turn or more: far
// from convex, and not to be seen whole from any point within. A sphere's tessellation moved by maps of space
// without folds, so watertight, of genus 0 and, but for its facets' width, free of self-intersections. Of
// about unit radius.
Mesh stone_mesh(const StoneOptions&, const Work& = {});

}  // namespace terrazzo

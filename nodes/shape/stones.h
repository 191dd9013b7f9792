// Random stones other than crushed ones.
#pragma once

#include <cstdint>
#include <string>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::shape {

struct StoneOptions {
  std::string kind;  // see stone_mesh
  std::uint64_t seed = 1;
  std::uint64_t item = 0;  // index of the stone for this seed
  Vec3 axes = Vec3::Ones();
  int detail = 3;  // 20·4^detail triangles, 0…6
};

// "pebble": worn smooth, almost convex. "shard": elongated (axes × (1.7, 1, 0.8)), rounded, with a few flat
// sides and sharp edges between them. "clinker": lobed, hollowed and bent by 2.2 to 2.8 radians; far from
// convex and not star-shaped. All are a tessellated sphere deformed by fold-free maps, so they are
// watertight, of genus 0 and, up to facet size, free of self-intersections. Radius about 1.
Mesh stone_mesh(const StoneOptions&, const Work& = {});

}  // namespace terrazzo::shape

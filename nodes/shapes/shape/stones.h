// Random stones other than crushed ones.
#pragma once

#include <cstdint>

#include "nodes/data/shapes.h"
#include "nodes/shapes/shape/solid_kind.h"
#include "runtime/work.h"

namespace terrazzo::shape {

struct StoneOptions {
  SolidKind kind = SolidKind::Pebble;  // Pebble, Shard or Clinker
  std::uint64_t seed = 1;
  std::uint64_t item = 0;  // index of the stone for this seed
  Vec3 axes = Vec3::Ones();
  int detail = 3;  // 20·4^detail triangles, 0…6
};

// Pebble: worn smooth, almost convex. Shard: elongated (axes × (1.7, 1, 0.8)), rounded, with a few flat
// sides and sharp edges between them. Clinker: lobed, hollowed and bent by 2.2 to 2.8 radians; far from
// convex and not star-shaped. All are a tessellated sphere deformed by fold-free maps, so they are
// watertight, of genus 0 and, up to facet size, free of self-intersections. Radius about 1.
Mesh stone_mesh(const StoneOptions&, const Work& = {});

}  // namespace terrazzo::shape

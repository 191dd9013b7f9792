// Particles that reach out of the periodic box, as meshes that fill it.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::exporting {

// The values are in the order of the parameter's words.
enum class Crossing {
  Once,      // every particle once, whole
  Repeated,  // whole, and again at opposite sides wherever a part of it is in the box
  Cut,       // cut at the sides of the box
};

// A packing to be written.
struct TiledPacking {
  Particles particles;
  Shapes shapes;
  std::vector<std::int32_t> index = {};  // of each particle in the packing it comes from; empty: its own
  std::size_t parts = 0;                 // of cut particles
  double fraction = 0;                   // of the box that the written meshes fill; only with Cut
};

// Particles in their order, each followed by its images or replaced by its parts, which are shapes of their
// own at the origin. Once: the packing as it is; else without voids. `flat_caps`: caps of smooth shapes have
// vertices of their own. Throws the errors of instances_of, and Error "open-mesh", "bad-box", "box-too-small"
// if a particle is more than 16 boxes wide, "too-large" if the parts do not fit into `memory` (bytes).
TiledPacking tiled_packing(const Particles&, const Shapes&, Crossing, bool flat_caps, std::uint64_t memory,
                           const Work& = {});

}  // namespace terrazzo::exporting

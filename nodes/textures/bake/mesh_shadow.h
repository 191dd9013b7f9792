// How much of the sky a mesh hides from itself.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/textures/bake/uv_texels.h"
#include "runtime/work.h"

namespace terrazzo::bake {

// For each texel the share of the sky above its triangle, weighted by the cosine to the normal, that the mesh
// leaves open: 1 is all. Texels of no triangle have the value of the nearest one, so `texels` are best
// without padding, whose places are beside the mesh. `places` are those of the mesh at `scale`. 256 rays from
// points at most 1/512 of the texture apart, in the same directions everywhere, so that no noise shows, and
// linear between points of one surface.
std::vector<float> open_sky(const Mesh&, const UvTexels&, const TexelPlaces&, double scale, const Work& = {});

}  // namespace terrazzo::bake

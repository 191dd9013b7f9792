// A texture in which every pair of triangles has a square of its own.
#pragma once

#include <functional>

#include "nodes/data/image.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::carve {

// Makes a square texture of `size` pixels, and the texture coordinates. Each triangle covers half a square of
// whole pixels whose centers lie on its edges, so that linear interpolation never mixes two triangles.
// `color(t, p)` is the color of triangle t at p, in the mesh's unit. Throws Error "bad-value" if a
// square would have fewer than 4 pixels.
Image bake_atlas(const Mesh&, int size, const std::function<Vec3f(std::size_t t, const Vec3& p)>& color,
                 std::vector<CornerUv>& uv, const Work& = {});

}  // namespace terrazzo::carve

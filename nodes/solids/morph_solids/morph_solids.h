// Solids between two solids.
#pragma once

#include "nodes/solids/patch_fill/fill.h"

namespace terrazzo::morph_solids {

using patch_fill::Torus;

// `a` and `b` are scene-linear colors of one size, at least 16 voxels along each axis, and tile. `weight` is
// the share of `b` at each voxel, 0 to 1. Voxels of weight 0 and 1 are those of a and b, bit for bit. Throws
// Error "one-color".
patch_fill::FillResult morph(const Torus<Vec3f>& a, const Torus<Vec3f>& b, const Torus<float>& weight,
                             const patch_fill::FillOptions&, const Work&);

}  // namespace terrazzo::morph_solids

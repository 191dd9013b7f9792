// Detail that blending has lost.
#pragma once

#include <array>

#include "nodes/morph_solids/torus.h"
#include "runtime/work.h"

namespace terrazzo::morph_solids {

// Amplifies the two finest scales of the voxels of weight between 0 and 1 until they are as strong as those
// of the textures, interpolated by the weight. All are working colors.
void restore_detail(const std::array<Torus<Vec3f>, 2>& textures, const Torus<float>& weight,
                    Torus<Vec3f>& field, const Work&);

}  // namespace terrazzo::morph_solids

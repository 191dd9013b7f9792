// Detail that blending has lost.
#pragma once

#include <array>

#include "nodes/solids/patch_fill/torus.h"
#include "runtime/work.h"

namespace terrazzo::patch_fill {

// Amplifies the two finest scales of the free voxels until they are as strong as those
// of the textures, interpolated by the weight. All are working colors.
void restore_detail(const std::array<Torus<Vec3f>, 2>& textures, const Torus<float>& weight,
                    const Torus<float>& free, Torus<Vec3f>& field, const Work&);

}  // namespace terrazzo::patch_fill

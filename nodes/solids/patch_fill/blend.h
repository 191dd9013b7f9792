// The colors of the solid between, from the matched patches of both.
#pragma once

#include <array>

#include "nodes/solids/patch_fill/matches.h"

namespace terrazzo::patch_fill {

struct BlendOptions {
  double exponent = 0.8;
  double window = 0.05;  // of the mean shift
};

// Each free voxel becomes the mean of the texels of all patches over it, weighted by
// (d² + mean d²)^((r − 2)/2). The patches of b have the share `weight` together, those of a the rest. A mean
// shift then moves it to the dominant cluster of the texels, so that structures do not fade.
void blend(const std::array<MatchLevel, 2>&, const std::array<Matches, 2>&, const Torus<float>& weight,
           const Torus<float>& free, const BlendOptions&, Torus<Vec3f>& field, const Work&);

}  // namespace terrazzo::patch_fill

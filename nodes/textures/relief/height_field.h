// Heights above a plane on a grid of texels whose opposite edges join, and what follows from them.
#pragma once

#include <vector>

#include "nodes/data/image.h"
#include "runtime/work.h"

namespace terrazzo::textures {

struct HeightField {
  int width = 0, height = 0;  // texels
  double mm_x = 1, mm_y = 1;  // of a texel
  std::vector<float> mm;      // row by row from the top

  float at(int x, int y) const { return mm[pixel_at(x, y, width)]; }
};

// Removes what a ball of this radius (mm), rolling below the surface, cannot touch: convex edges become
// round, concave ones stay. Morphological opening (Sternberg 1986). Nothing happens below one texel.
void round_edges(HeightField&, double radius, const Work& = {});

// Normals in tangent space as colors, (n + 1) / 2, with x to the right and y upwards in the picture (OpenGL's
// convention), from central differences.
Image normal_map(const HeightField&, const Work& = {});

// How much of the sky each texel sees, weighted by the cosine to its normal: 1 is all. Horizons in 16
// directions, and the integral between them in closed form (Jiménez et al. 2016, Practical realtime
// strategies for accurate indirect occlusion, equation 7).
Image occlusion_map(const HeightField&, const Work& = {});

}  // namespace terrazzo::textures

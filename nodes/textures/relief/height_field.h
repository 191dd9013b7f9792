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

// Removes what a paraboloid cannot touch from below whose apex has this radius of curvature (mm): convex
// edges become round, concave ones stay. An edge above a step of H becomes round over √(2 · radius · H).
// Morphological opening (van den Boomgaard, Smeulders 1994), whose time does not depend on the radius. Steps
// down to below `floor` (mm) count as if they ended there, so that a deep hole is as round as a shallow one.
// Nothing happens below one texel.
void round_edges(HeightField&, double radius, double floor, const Work& = {});

// Normals in tangent space as colors, (n + 1) / 2, with x to the right and y upwards in the picture (OpenGL's
// convention), from central differences.
Image normal_map(const HeightField&, const Work& = {});

// How much of the sky each texel sees, weighted by the cosine to its normal: 1 is all. Horizons in 16
// directions, and the integral between them in closed form (Jiménez et al. 2016, Practical realtime
// strategies for accurate indirect occlusion, equation 7).
Image occlusion_map(const HeightField&, const Work& = {});

}  // namespace terrazzo::textures

// Texture coordinates for a mesh that has none.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::bake {

struct BoxAtlas {
  std::vector<CornerUv> uv;
  int gap = 0;  // texels between charts
};

// Projects connected triangles that face the same side of a box onto that side, and packs these charts into
// rows, at the largest common scale, `gap` texels apart, or less if the gaps would take half of the
// texture. A chart that folds over itself overlaps. Throws Error "too-many-charts" if they do not fit at any
// scale.
BoxAtlas box_atlas(const Mesh&, int size, int gap, const Work& = {});

}  // namespace terrazzo::bake

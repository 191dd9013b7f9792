// Particles by example, learned from a user's strokes.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/texture/pixel_forest.h"
#include "nodes/data/image.h"
#include "nodes/data/strokes.h"
#include "nodes/photograph/segment/color/particles.h"

namespace terrazzo::segment {

struct Scribbles {
  const Strokes *particles = nullptr, *binder = nullptr;  // both needed
  const Strokes* not_material = nullptr;
};

// The share of the forest's trees that say particle, and not material, of each pixel of a section.
struct ScribbleMaps {
  std::vector<float> particle, not_material;
};

// Strokes are in pixels of the section `of_section`; every section of the stack is classified by what they
// teach there. Throws Error "no-strokes".
class ScribbleForest {
 public:
  ScribbleForest(const Image&, int of_section, const Scribbles&, std::uint64_t seed, const Work&);
  ScribbleMaps classify(const Image&, int section, const Work&) const;

 private:
  PixelForest forest_;
};

// Where most trees say particle, without specks, split at necks.
Particles2D find_particles_by_scribbles(const ScribbleMaps&, int width, int height, const SplitOptions&,
                                        const Work&);

}  // namespace terrazzo::segment

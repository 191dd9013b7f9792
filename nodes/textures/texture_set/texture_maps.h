// The maps of a finished plane through a packing.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/particles.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/textures/relief/height_field.h"
#include "nodes/textures/relief/solid_look.h"
#include "nodes/textures/texture_set/finished_surface.h"
#include "runtime/work.h"

namespace terrazzo::texture_set {

using textures::id_color;
using textures::Roughness;

struct TextureMaps {
  Image base_color;  // scene-linear, without light
  Image roughness;   // three equal channels, as in `occlusion` and `height` of the node
  Image id;          // id_color() of the particle at the center of each texel
  textures::HeightField height;
};

// Texels that contain an edge are averages of 4 × 4 points. `detail` may be null; `softness`: standard
// deviation of the blur of outlines, mm.
TextureMaps paint_maps(const FinishedSurface&, const Particles&, const section::SectionLayout&,
                       const Roughness&, const residual::ResidualField* detail, double softness,
                       const Work& = {});

}  // namespace terrazzo::texture_set

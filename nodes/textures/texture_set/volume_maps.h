// The maps of a finished plane through a volume.
#pragma once

#include "nodes/bodies/cutting/planes.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/textures/texture_set/texture_maps.h"

namespace terrazzo::texture_set {

// Colors and particles as node Section shows them. Particles are where the grid `density` is, or everywhere
// without one, and lie `relief` mm above the worn binder in the outlines that they have in the plane. All
// particles have one roughness. Throws the errors of cut_volume.
TextureMaps paint_maps(const Volume&, const section::SectionLayout&, double relief, const Roughness&,
                       const Work& = {});

}  // namespace terrazzo::texture_set

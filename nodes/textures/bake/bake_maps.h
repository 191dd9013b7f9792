// The maps of a solid on a mesh.
#pragma once

#include <vector>

#include "nodes/data/image.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/textures/bake/uv_texels.h"
#include "nodes/textures/relief/height_field.h"
#include "nodes/textures/relief/solid_look.h"
#include "runtime/work.h"

namespace terrazzo::bake {

struct BakedMaps {
  Image base_color, roughness, id;  // as in TextureSet
  std::vector<float> cover;         // share of each texel that particles cover
};

// The solid at the place of each texel. Texels that contain an edge are averages of 4 × 4 points. Texels of
// no triangle have the binder's color. `detail` may be null; `softness`: standard deviation of the blur of
// outlines, texels. Throws the errors of carving::check_shown.
BakedMaps bake_particles(const UvTexels&, const TexelPlaces&, const Particles&, const Shapes&,
                         const textures::Roughness&, const residual::ResidualField* detail, double softness,
                         const Work& = {});

// Trilinear samples of the grids Cd and density, and the nearest voxel's id. Without density, particles are
// everywhere. The volume is periodic. Throws Error "no-color".
BakedMaps bake_volume(const UvTexels&, const TexelPlaces&, const Volume&, const textures::Roughness&,
                      const Work& = {});

// Normals in tangent space of heights (mm) on the mesh, as (n + 1) / 2: x along the texture's right, y
// upwards in it, z along the triangle's normal, also where the texture is stretched or mirrored.
Image normals_on_mesh(const UvTexels&, const TexelPlaces&, const textures::HeightField&, const Work& = {});

}  // namespace terrazzo::bake

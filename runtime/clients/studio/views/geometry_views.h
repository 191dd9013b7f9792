// Shapes, particles and volumes in the forms that the page draws in three dimensions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"

namespace terrazzo::studio {

// All numbers are 32 bits, little-endian; lengths are mm; colors are sRGB bytes R, G, B, A. Throw Error
// "too-large" if there is more than a page can draw.

// Count, bytes per particle, and the box (3 floats). For each particle: position (3 floats), orientation
// (x, y, z, w), scale, size, shape, color. The alpha of a void is 0.
std::string particles_view(const Particles&);
// The number of shapes. For each: vertices, indices, triangles before reduction, and 1 if it has colors;
// then positions (3 floats each), normals (3), indices, and colors. Closed meshes without colors are reduced
// to about `triangles`.
std::string shapes_view(const Shapes&, int triangles);

// One plane of voxels, or a grid. Gray is the share of the way from lo to hi.
struct Slice {
  std::string grid = {};  // "": the first
  int axis = 2, index = 0;
  double lo = 0, hi = 1;
};
// A JSON object: size in voxels, edges of a voxel in mm, and grids with name, type and, of quantities, range.
nlohmann::json volume_head(const Volume&);
// Planes across x show y to the right and z up, across y x and z, across z x and y. Written as view_of()
// writes pictures; the number of sections is that of voxels along the axis.
std::string slice_view(const Volume&, const Slice&, int most);
// Width, height, depth, the factor by which they are reduced, and RGBA for every voxel, x fastest. Alpha is
// the share of material, if the volume has colors and coverage; else the gray of quantities.
std::string voxels_view(const Volume&, const Slice&, int most);

}  // namespace terrazzo::studio

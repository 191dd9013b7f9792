// Bodies as level sets: the grid `surface`, the signed distance in mm within three voxels.
#pragma once

#include <functional>

#include "nodes/bodies/carving/parts.h"
#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo::carve {

// Of a closed mesh in mm. Closed surfaces inside it that face inward are cavities.
Volume level_set(const Mesh&, double voxel, const Work& = {});
// Of all parts of a body, `mm` per world unit.
Volume level_set(const carving::BodyParts&, double mm, double voxel, const Work& = {});

// The surface as a mesh in mm, with a vertex in each voxel that it crosses (dual contouring by OpenVDB).
// Throws Error "empty-body" if there is none.
Mesh surface_of(const Volume&);

// Adds the grid `Cd` with the voxels of `surface`: color(p, n) of the nearest point p of the surface, mm,
// with its outward normal n.
void add_colors(Volume&, const std::function<Vec3f(const Vec3& p, const Vec3& n)>& color, const Work& = {});

// Moves all grids by `offset`, mm.
void move(Volume&, const Vec3& offset);

}  // namespace terrazzo::carve

// Measures and checks of closed triangle meshes.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

double mesh_volume(const Mesh&);        // mm³, positive if oriented outwards
double mesh_surface_area(const Mesh&);  // mm²
Vec3 mesh_centroid(const Mesh&);        // of the enclosed volume
double mesh_bounding_radius(const Mesh&, const Vec3& center = Vec3::Zero());
// (1/4π) Σ L·θ over the edges, negative for concave edges, in mm: the mean caliper diameter of a convex body,
// and for any closed mesh the mean over directions of ∫χ(section) dh (the χ identity in
// docs/validation.md; Santaló 1976, III.13.5).
double mesh_edge_curvature(const Mesh&);
// Mean distance of parallel tangent planes in mm, exact: that of the convex hull.
double mesh_mean_caliper(const Mesh&);
bool mesh_is_convex(const Mesh&, double tolerance = 1e-6);  // tolerance relative to the bounding radius

// Reasons why the mesh does not bound a solid, as text with the location ("edge 12–57 at (1.2, 0, 3) has 1
// triangle"). At most ten, then their number. Empty if the mesh is watertight, edge-manifold, consistently
// oriented and free of NaN.
std::vector<std::string> mesh_faults(const Mesh&);

void transform(Mesh&, const Mat3& linear, const Vec3& offset);

}  // namespace terrazzo

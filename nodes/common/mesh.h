// Measures and checks of closed triangle meshes, without a graph.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

double mesh_volume(const Mesh&);        // mm³, positive when oriented outwards
double mesh_surface_area(const Mesh&);  // mm²
Vec3 mesh_centroid(const Mesh&);        // of the enclosed volume
double mesh_bounding_radius(const Mesh&, const Vec3& center = Vec3::Zero());
// (1/4π) Σ L·θ over edges, concave ones negative: the mean caliper diameter of a convex body, and for any
// closed mesh the mean over directions of ∫χ(section) dh (NUMBERS' χ identity; Santaló 1976, III.13.5). mm.
double mesh_edge_curvature(const Mesh&);
// Mean distance of parallel tangent planes: of the convex hull, exact. mm.
double mesh_mean_caliper(const Mesh&);
bool mesh_is_convex(const Mesh&, double tolerance = 1e-6);  // tolerance relative to the bounding radius

// What stops a mesh from bounding a solid, in words with the place ("edge 12–57 at (1.2, 0, 3) has one
// triangle"); empty when it is watertight, edge-manifold, consistently oriented and free of NaN.
std::vector<std::string> mesh_faults(const Mesh&);

void transform(Mesh&, const Mat3& linear, const Vec3& offset);

}  // namespace terrazzo

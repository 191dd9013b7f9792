// Meshes of convex cells.
#pragma once

#include "nodes/data/shapes.h"
#include "nodes/packing/cells/convex_cell.h"

namespace terrazzo::tessellation {

// The cell's surface, in the cell's coordinates. Corners closer than 1e-6 of the cell's extent are merged.
// Each face becomes a fan around the mean of its corners, so neighbors triangulate a shared face alike.
Mesh cell_mesh(const ConvexCell& cell);

// Moves each vertex towards `center` onto the surface {x : Σ max(0, nᵢ·(x − center)/dᵢ)ᵖ = 1}, where dᵢ is
// the distance of plane i from the center and p = 3 / roundness: a convex body inside the planes, with
// rounded edges. The center must be inside of all planes. roundness: 0 (nothing is moved) to 1.
void round_edges(Mesh& mesh, const std::vector<Plane>& planes, const Vec3& center, double roundness);

}  // namespace terrazzo::tessellation

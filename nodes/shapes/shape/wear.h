// Worn and rough surfaces of stones.
#pragma once

#include "nodes/data/shapes.h"
#include "runtime/random.h"
#include "runtime/work.h"

namespace terrazzo::shape {

// Rounds edges and hollows: a right-angled edge gets about this radius (in units of the mesh). The surface
// diffuses by its Laplacian with cotangent weights (Desbrun et al. 1999); it also shrinks a little.
void round_edges(Mesh&, double radius, const Work& = {});

// Moves vertices along their normals by a random field of this standard deviation, with wavelengths from an
// eighth to 0.6 of `diameter`.
void roughen(Mesh&, double sd, double diameter, Random);

}  // namespace terrazzo::shape

// Grows packed particles into each other until each has its volume.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/packing/cells/effort.h"
#include "nodes/packing/cells/growth_shapes.h"
#include "runtime/work.h"

namespace terrazzo::tessellation {

struct GrowOptions {
  double gap = 0;            // distance between the flat faces of neighbors, mm
  double gap_variation = 0;  // of each pair, relative; 0 to 1
  double roundness = 0;      // of the edges between flat faces, 0 (sharp) to 1
  std::uint64_t seed = 1;    // of the variation
};

struct Grown {
  std::vector<Mesh> meshes;  // of each particle, in its own coordinates: centered at `position`, not rotated
  double flat = 0;           // share of the surface that is flat contact
};

// Every particle keeps its center and orientation and is enlarged until it has its volume (mm³). A plane
// between each pair of neighbors limits both: contacts become flat, and no two particles have a point in
// common. Planes move towards the particle that needs to grow less. A particle's own scale is where its
// growth begins; shapes that are not star-shaped about their centroid are cut along rays from it.
// Planes stop moving once the effort is spent.
// `shapes` were prepared for these particles.
Grown grow(const GrowthShapes& shapes, const Particles& packed, const std::vector<double>& volume,
           const GrowOptions& options, Effort& effort, const Work& work = {});

}  // namespace terrazzo::tessellation

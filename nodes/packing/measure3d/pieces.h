// Labels that mark phases instead of particles, and their connected pieces.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/packing/measure3d/raster.h"

namespace terrazzo::measure3d {

struct Phases {
  std::vector<std::int32_t> labels;  // those that are phases, in increasing order
  // Pieces have the labels first, first + 1, … in the raster.
  std::int32_t first = 0;
  std::vector<std::int32_t> label_of;  // the phase of each piece
  std::vector<char> spans;             // whether each piece reaches across the whole periodic box
};

// A label is a phase if none of its pieces (voxels that are connected by their faces) holds half of its
// voxels, or if one reaches across the whole box of a volume that tiles, where it has neither a center nor an
// end. Gives each piece of a phase a label of its own in `raster`; labels of particles stay.
Phases split_phases(Raster& raster, const Work&);

}  // namespace terrazzo::measure3d

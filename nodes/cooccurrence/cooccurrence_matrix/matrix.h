// The color co-occurrence matrix of a picture as a table and as curves.
#pragma once

#include "nodes/common/texture/color_levels.h"
#include "nodes/common/texture/cooccurrence.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "runtime/work.h"

namespace terrazzo::cooccurrence_matrix {

// All offsets of up to ±extent pixels, rows first, with (0, 0) in the middle.
std::vector<Vec3i> all_offsets(int extent);

// One row per offset and pair of levels: Δx, Δy (rows down), home and remote level from 1, number of pairs of
// pixels at the offset, and the share of them with these levels.
Table matrix_table(const Cooccurrence&);

// Two plots of the probability that a pixel and the one at Δy (left; Δx = 0) or Δx (right; Δy = 0) both have
// the level: figure 2 of the paper. `level`: from 1, or 0 for all.
Image slice_figure(const Cooccurrence&, int extent, int level);

}  // namespace terrazzo::cooccurrence_matrix

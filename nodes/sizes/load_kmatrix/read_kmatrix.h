// Reads a K matrix from JSON, as Export and `terrazzo show --json` write it.
#pragma once

#include <string>

#include "nodes/data/kmatrix.h"

namespace terrazzo::load_kmatrix {

// The fields are those of KMatrix: classes (1 to 4096), averaging, residual, and for each entry of `shapes`
// probability (0 to 1), class (≥ −1), mean_caliper, max_section_area, volume, profiles_per_caliper (> 0), K
// (by row, ≥ 0) and cdf (at least two, ascending to 1). Numbers are read to the last bit. `file` is used in
// messages only. Throws Error "unreadable-file" if the structure is another, "bad-kmatrix" with the index of
// the shape.
KMatrix read_kmatrix(const std::string& text, const std::string& file);

}  // namespace terrazzo::load_kmatrix

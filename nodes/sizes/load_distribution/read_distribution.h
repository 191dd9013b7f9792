// Reads a size distribution from JSON, as Export and `terrazzo show --json` write it.
#pragma once

#include <string>

#include "nodes/data/size_distribution.h"

namespace terrazzo::load_distribution {

// The fields are those of SizeDistribution: class_edges (n + 1 ascending sizes ≥ 0 in mm), volume_fraction,
// d_max, goodness_of_fit (≥ 0), and for each entry of `shapes` shape (≥ −1), class (≥ 0), N_V, low and high
// (n numbers ≥ 0, per mm³). Numbers are read to the last bit. `file` is used in messages only. Throws Error
// "unreadable-file" if the structure is another, "bad-distribution" with the index of the entry.
SizeDistribution read_distribution(const std::string& text, const std::string& file);

}  // namespace terrazzo::load_distribution

// Figure of a packing's statistics.
#pragma once

#include <string>

#include "nodes/common/plot/plot.h"
#include "nodes/data/image.h"
#include "nodes/data/linear.h"
#include "nodes/data/table.h"

namespace terrazzo::packing {

// Requested and achieved particles by size, from size_table (statistics.h).
Plot plot_of_sizes(const Table& sizes, const std::string& requested, const std::string& achieved);

// Plots size_table, pair_correlation and sections_per_area (statistics.h) side by side.
Image figure_of(const Table& sizes, const Table& correlation, const Vec3& sections_per_area);

}  // namespace terrazzo::packing

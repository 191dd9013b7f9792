// The figure and the table of GrainSize.
#pragma once

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/sizes/grain_size/grain_size.h"

namespace terrazzo::grain_size {

enum class Scale { Mm, Phi };  // φ = −log₂(diameter / mm)

// Columns measure, value, low, high, unit. With φ, only diameters are converted, and means are those of φ.
Table table_of(const std::vector<Measure>&, const CrystalSizes*, Scale);

// Cumulative curves by number, area and weight: the finer share against mm, or the coarser share against φ;
// and the crystal sizes, if there are any.
Image figure_of(const Sizes&, const CrystalSizes*, Scale);

// One row per profile: its place, what Export writes, and mean colors, which may be empty.
Table grains_of(const Profiles&, const std::vector<ProfileColumn>&, const std::vector<Vec3f>& mean_colors,
                double pixel_size);

}  // namespace terrazzo::grain_size

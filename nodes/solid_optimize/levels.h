// Scales of a solid and of its exemplars.
#pragma once

#include <vector>

#include "nodes/common/quantiles.h"
#include "nodes/solid_optimize/solid_optimize.h"

namespace terrazzo::solid_optimize {

using Pyramid = std::vector<ExemplarLevel>;

std::size_t voxels(const Vec3i& size);
// Voxels of a level of a solid of size `full`.
Vec3i box_at(const Vec3i& full, int level, int levels);
std::vector<const ExemplarLevel*> level_of(const std::vector<Pyramid>&, int level);
// Per channel, the values of all exemplars that are seen, each plane with equal weight.
std::vector<Quantiles> level_values(const std::vector<const ExemplarLevel*>&, const SolidSettings&,
                                    int channels);
// Of a solid's levels the finest that is made whole: the last one, unless the solid is local.
int whole_level(const SolidSettings&, int levels);
// Levels, from the coarsest on, on which patches are matched by the guide too. Where lines run is settled on
// those that are made whole; local ones go by colour alone, and so does the recipe of 2011.
int guided_levels(const SolidSettings&, int levels);
// What searches on all levels share.
SearchSettings search_settings(const SolidSettings&);
// Iterations of each level.
std::vector<int> iterations_of(const SolidSettings&, int levels);

}  // namespace terrazzo::solid_optimize

// Scales of a solid and of its exemplars.
#pragma once

#include <vector>

#include "nodes/common/texture/quantiles.h"
#include "nodes/solids/synthesis/options/solid_options.h"
#include "nodes/solids/synthesis/whole/result.h"

namespace terrazzo::solids {

using Pyramid = std::vector<ExemplarLevel>;

std::size_t voxels(const Vec3i& size);
// Size in voxels of a level of a solid of size `full`.
Vec3i box_at(const Vec3i& full, int level, int levels);
std::vector<const ExemplarLevel*> level_of(const std::vector<Pyramid>&, int level);
// Per channel, the values of all exemplars in use, weighted equally per plane, under usable patches only.
std::vector<Quantiles> level_values(const std::vector<const ExemplarLevel*>&, const SolidOptions&,
                                    int channels);
// The finest level that is made whole: the last one, unless the solid is blockwise.
int whole_level(const SolidOptions&, int levels);
// Number of levels, counted from the coarsest, that use the guidance channel for matching. The courses of
// lines are settled on levels that are made whole; blockwise levels match by color only, and so does the
// reference method.
int guided_levels(const SolidOptions&, int levels);
// Search settings common to all levels.
SearchOptions search_settings(const SolidOptions&);
// Iterations per level.
std::vector<int> iterations_of(const SolidOptions&, int levels);

}  // namespace terrazzo::solids

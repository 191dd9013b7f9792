// The passes that turn the carried matches of a part of a level into its voxels.
#pragma once

#include <vector>

#include "nodes/solids/synthesis/blockwise/search.h"
#include "nodes/solids/synthesis/blockwise/statistics.h"
#include "nodes/solids/synthesis/matching/blend.h"

namespace terrazzo::solids {

// The voxels that each step of a part must make to provide the voxels wanted in the end.
struct BlockPlan {
  std::vector<TorusBox> blend;   // after the matches are carried up, and after each iteration
  std::vector<TorusBox> finish;  // after each round
};
BlockPlan block_plan(const TorusBox& wanted, int iterations, int finish_rounds);
// Blend 0, then searches and blends in turn.
struct BlockPasses {
  const std::vector<const ExemplarLevel*>& exemplars;
  const LevelStatistics& statistics;
  const BlockPlan& plan;
  const std::vector<float>& windows;  // of each blend's mean shift
  SearchOptions search;               // of the first iteration
  double power;                       // of weights
};

// Where statistics are measured while the passes run, the target distribution of the values there, and the
// place to store them: the object that `statistics` of the passes refers to.
struct BlockProbe {
  const TorusBox& box;
  const std::vector<Quantiles>& values;  // per channel
  LevelStatistics& measured;
};

// Measure a region: after the last blend, before its map; and after the last search, before its weights.
void measure_values(BlockProbe&, const BlockRegion&, const Work&);
void measure_floors(BlockProbe&, const BlockRegion&);

// Runs all passes on the processor, from the carried matches of a region. The last blend runs only if
// `to_blend`; it uses `sources` (may be null; has the field's shape) and `features` (per exemplar) as
// blend_patches does.
void run_passes(const BlockPasses&, bool to_blend, BlockProbe*, BlendSources* sources,
                const std::vector<const std::vector<Vec3f>*>& features, BlockRegion&, const Work&);
// One blend and the map of values after it.
void blend_pass(const BlockPasses&, std::size_t blend, BlockProbe*, BlendSources* sources,
                const std::vector<const std::vector<Vec3f>*>& features, BlockRegion&, const Work&);

// The values of one channel in a box.
std::vector<float> values_in(const TorusBox&, const BlockRegion&, int channel);

}  // namespace terrazzo::solids

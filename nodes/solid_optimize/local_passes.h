// The passes that turn the carried matches of a part of a level into its voxels.
#pragma once

#include <vector>

#include "nodes/solid_optimize/blend.h"
#include "nodes/solid_optimize/local_search.h"
#include "nodes/solid_optimize/local_statistics.h"

namespace terrazzo::solid_optimize {

// The voxels that each step of a part must make to provide the voxels wanted in the end.
struct LocalPlan {
  std::vector<LocalBox> blend;   // after the matches are carried up, and after each iteration
  std::vector<LocalBox> finish;  // after each round
};
LocalPlan local_plan(const LocalBox& wanted, int iterations, int finish_rounds);
// Blend 0, then searches and blends in turn.
struct LocalPasses {
  const std::vector<const ExemplarLevel*>& exemplars;
  const LevelStatistics& statistics;
  const LocalPlan& plan;
  const std::vector<float>& windows;  // of each blend's mean shift
  SearchSettings search;              // of the first iteration
  double power;                       // of weights
};

// Where statistics are measured while the passes run, the target distribution of the values there, and the
// place to store them: the object that `statistics` of the passes refers to.
struct LocalProbe {
  const LocalBox& box;
  const std::vector<Quantiles>& values;  // per channel
  LevelStatistics& measured;
};

// Measure a region: after the last blend, before its map; and after the last search, before its weights.
void measure_values(LocalProbe&, const LocalRegion&, const Work&);
void measure_floors(LocalProbe&, const LocalRegion&);

// Runs all passes on the processor, from the carried matches of a region. The last blend runs only if
// `to_blend`; it uses `sources` (may be null; has the field's shape) and `features` (per exemplar) as
// blend_patches does.
void run_passes(const LocalPasses&, bool to_blend, LocalProbe*, BlendSources* sources,
                const std::vector<const std::vector<Vec3f>*>& features, LocalRegion&, const Work&);
// One blend and the map of values after it.
void blend_pass(const LocalPasses&, std::size_t blend, LocalProbe*, BlendSources* sources,
                const std::vector<const std::vector<Vec3f>*>& features, LocalRegion&, const Work&);

// The values of one channel in a box.
std::vector<float> values_in(const LocalBox&, const LocalRegion&, int channel);

}  // namespace terrazzo::solid_optimize

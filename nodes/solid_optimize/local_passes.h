// What makes a part of a level of the matches that were carried up to it.
#pragma once

#include <vector>

#include "nodes/solid_optimize/local_search.h"
#include "nodes/solid_optimize/local_statistics.h"

namespace terrazzo::solid_optimize {

// Which voxels each step of a part has to make for the voxels wanted in the end.
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
  std::uint64_t seed;
  int first_iteration;  // of those of all levels
  double power;         // of weights
};

}  // namespace terrazzo::solid_optimize

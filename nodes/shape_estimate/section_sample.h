// Features of a fixed set of sections of a body. All bodies are cut by the same planes, so that differences
// between them are not random.
#pragma once

#include <vector>

#include "nodes/common/stereology/outline_features.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// Profiles of isotropic uniform random planes. Each represents `weight` profiles.
struct FeatureSample {
  std::vector<OutlineFeatures> features;
  std::vector<double> root_area;  // √area, mm
  std::vector<double> weight;
};

// Sections with evenly spread directions and depths (R3 sequence, Roberts 2018), `planes` of them starting at
// element `first`. The weight of a direction is the body's width along it, in proportion to how often random
// planes meet it. Disjoint profiles are counted separately.
FeatureSample sample_sections(const Mesh&, std::size_t planes, const OutlineMeasuring&,
                              std::size_t first = 0);

// Removes profiles whose root area is below `smallest` times the one that a tenth of them (by weight) exceed,
// as candidates_of does with observed profiles.
void drop_small(FeatureSample&, double smallest);

double total_weight(const FeatureSample&);

}  // namespace terrazzo::shape_estimate

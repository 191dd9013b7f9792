// Features of a fixed set of sections of a body: the same planes for every body, so that bodies differ by
// what they are and not by lot.
#pragma once

#include <vector>

#include "nodes/common/outline_features.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

// Profiles of isotropic uniform random planes, each standing for `weight` of them.
struct FeatureSample {
  std::vector<OutlineFeatures> features;
  std::vector<double> root_area;  // √area, mm
  std::vector<double> weight;
};

// Evenly spread directions and depths (R3 sequence, Roberts 2018), `planes` of them from number `first` on. A
// direction counts by the body's width in it, as planes meet it. Disjoint profiles count apart.
FeatureSample sample_sections(const Mesh&, std::size_t planes, const OutlineMeasuring&,
                              std::size_t first = 0);

// Leaves out profiles of a root area below `smallest` of the one that a tenth of them (by weight) exceed:
// what candidates_of does to observed ones.
void drop_small(FeatureSample&, double smallest);

double total_weight(const FeatureSample&);

}  // namespace terrazzo::shape_estimate

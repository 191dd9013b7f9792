// Features of a fixed set of sections of a body. All bodies are cut by the same planes, so that differences
// between them are not random.
#pragma once

#include <vector>

#include "nodes/common/stereology/outline_features.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct CutProfile {
  Loop loop;             // outer outline, in the body's units
  double root_area = 0;  // √area
  double perimeter = 0;
  double weight = 1;  // number of profiles that it represents
  double scale = 0;   // mm per unit of the body at which it is seen; 0: at any scale
};

// Sections with evenly spread directions and depths (R3 sequence, Roberts 2018), `planes` of them starting at
// element `first`. The weight of a direction is the body's width along it, in proportion to how often random
// planes meet it. Disjoint profiles are counted separately.
std::vector<CutProfile> cut_sections(const Mesh&, std::size_t planes, std::size_t first = 0);

// Removes sections whose root area is below `smallest` times the one that a tenth of them (by weight) exceed,
// as candidates_of does with observed profiles.
void drop_small(std::vector<CutProfile>&, double smallest);

// Profiles of isotropic uniform random planes. Each represents `weight` profiles.
struct FeatureSample {
  std::vector<OutlineFeatures> features;
  std::vector<double> root_area;  // √area, in the units of the sections
  std::vector<double> weight;
};

double total_weight(const FeatureSample&);

// Measures sections. Outlines of sections with a scale are also blurred by `blur`, mm, as a photograph of
// that scale blurs them. Omits sections without area.
FeatureSample measured(const std::vector<CutProfile>&, const OutlineMeasuring&, double blur = 0);

}  // namespace terrazzo::shape_estimate

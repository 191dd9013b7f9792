// Single particles from the maps of the network.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/segment/network.h"

namespace terrazzo::segment {

struct Instance {
  std::vector<std::int32_t> pixels;  // indices, ascending
  double score = 0;                  // 0 to 1
};

// The basins of distance × inside × (1 − border / 2) where inside exceeds 0.4. Basins whose pass is less than
// 0.12 below the lower summit are one particle (watershed by dynamics; Grimaud 1992), and so are neighbors
// along whose common border the map of borders stays below 0.3 on average. Basins with a summit below 0.2
// are no particles. A mode filter of 3 × 3 pixels takes fringes off the outlines.
std::vector<Instance> find_instances(const NetworkMaps&, const Work&);

// The score of each label from 1 to `count`, made by any method: the mean of inside × the mean of
// border along the outline × (1 − the mean of border within) × the summit of distance × inside × (1 − border
// / 2).
std::vector<double> score_labels(const NetworkMaps&, const std::vector<std::int32_t>& labels, int count);

// Accepts instances in order of their scores, unless more than 0.4 of one is already covered by accepted
// ones; the rest of it is kept if it stays in one piece of at least `min_area` pixels. Returns labels from 1
// with their scores. Use it to join what was found at several scales.
struct Accepted {
  std::vector<std::int32_t> labels;
  std::vector<double> scores;
  std::vector<std::size_t> from;  // index of the instance
};
Accepted accept_instances(std::vector<Instance> instances, int width, int height, double min_area,
                          double min_score, const Work&);

}  // namespace terrazzo::segment

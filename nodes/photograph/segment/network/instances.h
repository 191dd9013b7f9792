// The best of overlapping particles.
#pragma once

#include <cstdint>
#include <vector>

#include "runtime/work.h"

namespace terrazzo::segment {

struct Instance {
  std::vector<std::int32_t> pixels;  // indices, ascending
  double score = 0;                  // 0 to 1; above 1 to come before all others
  double explained = 0;              // share of it that others must cover to replace it
};

struct Accepted {
  std::vector<std::int32_t> labels;
  std::vector<double> scores;
  std::vector<std::size_t> from;  // index of the instance
};

// For each of the labels from 1 to `count`, at k − 1: those of the instances in `order` that lie in it, in
// that order. At least 0.6 of such an instance lies in the label, and it has at most 0.8 of the label's area,
// since larger ones are versions of the same particle.
std::vector<std::vector<std::size_t>> instances_within(const std::vector<std::int32_t>& labels,
                                                       std::size_t count, const std::vector<Instance>&,
                                                       const std::vector<std::size_t>& order, const Work&);

// Accepts instances in order of their scores, unless more than 0.4 of one is already covered by accepted
// ones; the rest of it is kept if it stays in one piece of at least `min_area` pixels. Then an accepted
// instance gives way to others that lie in it, if these are worth more together: a mound of soil between
// stones often looks more like a particle than each stone that sticks out of it. An instance is worth
// `worth(score) - worth(min_score)`, and gives way only to others that cover at least `explained` of it.
// Returns labels from 1, best score first, with their scores.
Accepted accept_instances(const std::vector<Instance>& instances, int width, int height, double min_area,
                          double min_score, double (*worth)(double score), const Work&);

}  // namespace terrazzo::segment

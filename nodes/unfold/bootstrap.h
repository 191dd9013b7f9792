// Intervals by drawing the observed profiles again.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "nodes/unfold/observation.h"
#include "runtime/random.h"
#include "runtime/work.h"

namespace terrazzo {

struct Intervals {
  std::vector<double> low, high;  // 5 % and 95 % quantiles
};

// `estimate` gets the weights of one repetition (some zero), the ratio of the areas seen then and now, and
// random numbers of its own. Each profile comes back a Poisson number of times of mean 1, for the number of
// profiles is random too; from 10 sections on, whole sections are drawn instead, so that what differs between
// them counts: one fewer than there are, weighted up (Rao and Wu 1988), else few sections seem too much
// alike. The same seed and stream: the same bits.
Intervals bootstrap(const Observation&, int sections, int repetitions, std::uint64_t seed,
                    std::uint64_t stream,
                    const std::function<Eigen::VectorXd(const std::vector<double>& weights, double area_ratio,
                                                        Random&)>& estimate,
                    const Work&);

}  // namespace terrazzo

// Bootstrap intervals over the observed profiles.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "nodes/sizes/unfolding/observation.h"
#include "runtime/random.h"
#include "runtime/work.h"

namespace terrazzo::unfolding {

struct Intervals {
  std::vector<double> low, high;  // 5 % and 95 % quantiles
};

// Between values number q·(n + 1), by linear interpolation: a further value lies below it with probability q
// (type 6 of Hyndman and Fan 1996). Sorts the values, of which there is at least one.
double quantile(std::vector<double>& values, double q);

// How often each profile appears in one repetition. A Poisson number of times with mean 1, because the number
// of profiles is random too. From 10 sections on, whole sections are resampled instead, so that the
// differences between sections count: one section fewer than there are, weighted up (Rao and Wu 1988);
// otherwise the variance between few sections would be underestimated. `section`: that of each profile.
std::vector<double> draw_counts(const std::vector<int>& section, int sections, Random&);

// Resamples the profiles by draw_counts and calls `estimate` with the weights of one repetition (some zero),
// the ratio of its covered area to the original one, and a random stream for that repetition. Equal seed and
// stream yield identical bits.
Intervals bootstrap(const Observation&, int sections, int repetitions, std::uint64_t seed,
                    std::uint64_t stream,
                    const std::function<Eigen::VectorXd(const std::vector<double>& weights, double area_ratio,
                                                        Random&)>& estimate,
                    const Work&);

}  // namespace terrazzo::unfolding

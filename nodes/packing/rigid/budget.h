// The work that a packing may take, counted in steps and never in seconds, so that the result depends on
// neither the machine nor the number of threads.
#pragma once

#include <algorithm>
#include <cstddef>

namespace terrazzo::packing {

// A step is an iteration of all bodies in which each takes kTestsPerBody contact tests. Cheaper iterations
// also count as one step. Dearer ones count as several, so that jagged shapes do not take longer than round
// ones.
struct Budget {
  static constexpr double kTestsPerBody = 100;

  double limit = 4000;     // steps
  double expected = 1000;  // steps that a packing like this usually takes, for progress()
  double used = 0;

  static double steps(std::size_t tests, std::size_t bodies) {
    return static_cast<double>(tests) /
           (kTestsPerBody * static_cast<double>(std::max<std::size_t>(bodies, 1)));
  }
  double left() const { return limit - used; }
  // Share of the work done, 0 to 1: linear in the steps up to 0.9 at `expected`, then up to 1 at `limit`.
  double progress() const {
    const double first = std::min(expected, limit);
    if (used < first) return 0.9 * used / first;
    return limit > first ? std::min(1.0, 0.9 + 0.1 * (used - first) / (limit - first)) : 1.0;
  }
};

}  // namespace terrazzo::packing

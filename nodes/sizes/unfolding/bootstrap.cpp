#include "nodes/sizes/unfolding/bootstrap.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::unfolding {
namespace {

int poisson_1(Random& random) {
  double u = random.uniform(), p = std::exp(-1.0);
  int k = 0;
  while (u >= p && k < 50) {
    u -= p;
    p /= ++k;
  }
  return k;
}

double quantile(std::vector<double>& values, double q) {
  std::sort(values.begin(), values.end());
  const double at = q * (values.size() - 1);
  const std::size_t i = at;
  const std::size_t j = std::min(i + 1, values.size() - 1);
  return values[i] + (at - i) * (values[j] - values[i]);
}

}  // namespace

Intervals bootstrap(const Observation& q, int sections, int repetitions, std::uint64_t seed,
                    std::uint64_t stream,
                    const std::function<Eigen::VectorXd(const std::vector<double>& weights, double area_ratio,
                                                        Random&)>& estimate,
                    const Work& work) {
  const bool by_section = sections >= 10;
  const double again = static_cast<double>(sections) / std::max(1, sections - 1);
  double area = 0;
  for (std::size_t i = 0; i < q.size.size(); ++i) area += q.weight[i] * q.size[i] * q.size[i];
  std::vector<Eigen::VectorXd> results(repetitions);
  work.parallel(repetitions, 4, [&](std::size_t begin, std::size_t end) {
    std::vector<double> weight(q.size.size());
    std::vector<int> times(by_section ? sections : 0);
    for (std::size_t r = begin; r < end; ++r) {
      work.check();
      Random random(seed, stream, r);
      if (by_section) {
        std::fill(times.begin(), times.end(), 0);
        for (int s = 0; s + 1 < sections; ++s) ++times[random.below(sections)];
      }
      double drawn = 0;
      for (std::size_t i = 0; i < weight.size(); ++i) {
        const double n = by_section ? again * times[std::clamp(q.section[i], 0, sections - 1)]
                                    : static_cast<double>(poisson_1(random));
        weight[i] = n * q.weight[i];
        drawn += weight[i] * q.size[i] * q.size[i];
      }
      results[r] = estimate(weight, area > 0 ? drawn / area : 1, random);
    }
  });
  Intervals intervals;
  std::vector<double> values(repetitions);
  for (Eigen::Index j = 0; j < results[0].size(); ++j) {
    for (int r = 0; r < repetitions; ++r) values[r] = results[r][j];
    intervals.low.push_back(quantile(values, 0.05));
    intervals.high.push_back(quantile(values, 0.95));
  }
  return intervals;
}

}  // namespace terrazzo::unfolding

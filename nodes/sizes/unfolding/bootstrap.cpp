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

}  // namespace

double quantile(std::vector<double>& values, double q) {
  std::sort(values.begin(), values.end());
  const double last = values.size() - 1.0;
  const double at = std::clamp(q * (values.size() + 1) - 1, 0.0, last);
  const std::size_t i = at;
  const std::size_t j = std::min(i + 1, values.size() - 1);
  return values[i] + (at - i) * (values[j] - values[i]);
}

std::vector<double> draw_counts(const std::vector<int>& section, int sections, Random& random) {
  std::vector<double> out;
  out.reserve(section.size());
  if (sections < 10) {
    for (std::size_t i = 0; i < section.size(); ++i) out.push_back(poisson_1(random));
    return out;
  }
  const double again = static_cast<double>(sections) / (sections - 1);
  std::vector<int> times(sections, 0);
  for (int s = 0; s + 1 < sections; ++s) ++times[random.below(sections)];
  for (const int s : section) out.push_back(again * times[std::clamp(s, 0, sections - 1)]);
  return out;
}

Intervals bootstrap(const Observation& q, int sections, int repetitions, std::uint64_t seed,
                    std::uint64_t stream,
                    const std::function<Eigen::VectorXd(const std::vector<double>& weights, double area_ratio,
                                                        Random&)>& estimate,
                    const Work& work) {
  double area = 0;
  for (std::size_t i = 0; i < q.size.size(); ++i) area += q.weight[i] * q.size[i] * q.size[i];
  std::vector<Eigen::VectorXd> results(repetitions);
  work.parallel(repetitions, 4, [&](std::size_t begin, std::size_t end) {
    std::vector<double> weight(q.size.size());
    for (std::size_t r = begin; r < end; ++r) {
      work.check();
      Random random(seed, stream, r);
      const std::vector<double> counts = draw_counts(q.section, sections, random);
      double drawn = 0;
      for (std::size_t i = 0; i < weight.size(); ++i) {
        weight[i] = counts[i] * q.weight[i];
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

#include "nodes/study/study_anova/people.h"

#include <algorithm>
#include <cmath>

namespace terrazzo::study_anova {

namespace {

struct Sum {
  double sum = 0;
  int n = 0;
  double mean() const { return sum / n; }
};

}  // namespace

double value_of(const Answer& a, Quantity q) {
  if (q == Quantity::Seconds) return a.seconds;
  // Nobody can look and click in less than a twentieth of a second, so the logarithm is bounded there.
  if (q == Quantity::LogSeconds) return std::log(std::max(a.seconds, 0.05));
  if (a.decoy == "none") return std::numeric_limits<double>::quiet_NaN();
  return a.choice != a.decoy;
}

Spread spread_of(const std::vector<Answer>& answers, const std::string& method, const std::string& shape,
                 Quantity q) {
  std::map<std::string, Sum> people;
  Spread out;
  for (const Answer& a : answers) {
    if ((!method.empty() && a.method != method) || (!shape.empty() && a.shape != shape)) continue;
    const double v = value_of(a, q);
    if (std::isnan(v)) continue;
    Sum& s = people[a.participant];
    s.sum += v;
    ++s.n;
    ++out.answers;
  }
  out.people = people.size();
  if (people.empty()) return out;
  Sum all;
  for (const auto& [name, s] : people) {
    all.sum += s.mean();
    ++all.n;
  }
  out.mean = all.mean();
  if (all.n < 2) return out;
  double squares = 0;
  for (const auto& [name, s] : people) squares += (s.mean() - out.mean) * (s.mean() - out.mean);
  out.sd = std::sqrt(squares / (all.n - 1));
  return out;
}

PeopleMeans means_by_person(const std::vector<Answer>& answers, const std::vector<std::string>& methods,
                            const std::vector<std::string>& shapes, Quantity q) {
  const std::size_t cells = methods.size() * shapes.size();
  std::map<std::string, std::vector<Sum>> people;
  for (const Answer& a : answers) {
    const auto m = std::find(methods.begin(), methods.end(), a.method);
    const auto s = std::find(shapes.begin(), shapes.end(), a.shape);
    const double v = value_of(a, q);
    if (m == methods.end() || s == shapes.end() || std::isnan(v)) continue;
    auto& sums = people[a.participant];
    sums.resize(cells);
    Sum& sum = sums[(m - methods.begin()) * shapes.size() + (s - shapes.begin())];
    sum.sum += v;
    ++sum.n;
  }
  PeopleMeans out;
  for (const auto& [name, sums] : people) {
    if (std::any_of(sums.begin(), sums.end(), [](const Sum& s) { return s.n == 0; })) {
      ++out.left_out;
      continue;
    }
    out.rows.emplace_back();
    for (const Sum& s : sums) out.rows.back().push_back(s.mean());
  }
  return out;
}

}  // namespace terrazzo::study_anova

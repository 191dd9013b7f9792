#include "nodes/shapes/shape_estimate/size_selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "nodes/data/indices.h"

namespace terrazzo::shape_estimate {

namespace {

constexpr double kStep = 0.08;       // width of a class, of the logarithm of the size
constexpr int kClasses = 40;         // at most: sizes up to e^3.2 times the smallest
constexpr double kLeastSeen = 0.05;  // classes whose particles show fewer of their sections are not estimated
constexpr int kRounds = 200;

// The share of sections by relative root area in classes of kStep; class k starts at e^(first + k·kStep).
struct Sections {
  std::vector<double> share;
  double first = 0;
};

double mean_root_area(const std::vector<CutProfile>& sections) {
  double sum = 0, total = 0;
  for (const CutProfile& s : sections) {
    sum += s.weight * s.root_area;
    total += s.weight;
  }
  return sum / total;
}

Sections relative_sizes(const std::vector<std::vector<CutProfile>>& bodies) {
  constexpr double kFirst = -4;  // e^−4 of the mean: smaller sections are counted there
  Sections out{std::vector<double>(static_cast<std::size_t>(6 / kStep), 0), kFirst};
  for (const auto& body : bodies) {
    if (body.empty()) continue;
    const double mean = mean_root_area(body);
    double total = 0;
    for (const CutProfile& s : body) total += s.weight;
    for (const CutProfile& s : body) {
      const double k = std::floor((std::log(s.root_area / mean) - kFirst) / kStep);
      const double most = static_cast<double>(out.share.size()) - 1;
      out.share[static_cast<std::size_t>(std::clamp(k, 0.0, most))] += s.weight / total;
    }
  }
  const double sum = std::accumulate(out.share.begin(), out.share.end(), 0.0);
  for (double& v : out.share) v /= sum;
  return out;
}

}  // namespace

SizeSelection::SizeSelection(const std::vector<double>& root_area,
                             const std::vector<std::vector<CutProfile>>& typical) {
  if (root_area.empty()) return;
  mean_ = std::accumulate(root_area.begin(), root_area.end(), 0.0) / root_area.size();
  limit_ = *std::min_element(root_area.begin(), root_area.end());
  const double limit = std::log(limit_),
               top = std::log(*std::max_element(root_area.begin(), root_area.end()));
  const Sections sections = relative_sizes(typical);
  const int n_sections = sections.share.size();
  // Profiles in classes above the limit.
  const int observed = std::clamp(static_cast<int>((top - limit) / kStep) + 1, 1, kClasses);
  std::vector<double> count(observed, 0);
  for (const double v : root_area)
    count[std::clamp<int>((std::log(v) - limit) / kStep, 0, observed - 1)] += 1;
  // A particle of class j, whose mean section is e^(lowest + j·kStep) times the limit, shows a profile of
  // class k by chance sections.share[k − j + shift].
  const int below = round_up(-sections.first / kStep),
            above = n_sections - below;  // classes of sections below and above the mean
  const int sizes = observed + above;    // the smallest shows only its largest section
  const auto chance = [&](int j, int k) {
    const int s = k - (j - above) + below;
    return s >= 0 && s < n_sections ? sections.share[s] : 0.0;
  };
  std::vector<double> visible(sizes, 0), seen(visible), next(visible);
  for (int j = 0; j < sizes; ++j)
    for (int s = std::max(0, below - (j - above)); s < n_sections; ++s) visible[j] += sections.share[s];
  double start = 0;
  for (int j = 0; j < sizes; ++j) start += seen[j] = visible[j] >= kLeastSeen;
  if (!(start > 0)) return;
  for (double& v : seen) v /= start;
  for (int round = 0; round < kRounds; ++round) {
    std::fill(next.begin(), next.end(), 0.0);
    for (int k = 0; k < observed; ++k) {
      if (count[k] == 0) continue;
      double sum = 0;
      for (int j = 0; j < sizes; ++j)
        if (seen[j] > 0) sum += seen[j] / visible[j] * chance(j, k);
      if (!(sum > 0)) continue;
      for (int j = 0; j < sizes; ++j)
        if (seen[j] > 0) next[j] += count[k] * seen[j] / visible[j] * chance(j, k) / sum;
    }
    double total = 0;
    for (const double v : next) total += v;
    if (!(total > 0)) return;
    for (int j = 0; j < sizes; ++j) seen[j] = next[j] / total;
  }
  // Hits of particles by size, and how many of those show a section of a relative size above the limit.
  std::vector<double> hits(sizes, 0);
  for (int j = 0; j < sizes; ++j)
    if (visible[j] >= kLeastSeen) hits[j] = seen[j] / visible[j];
  first_ = -(observed + kClasses) * kStep;
  seen_.assign(std::lround((2.0 - first_) / kStep), 0);
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const double relative = first_ + i * kStep;
    for (int j = 0; j < sizes; ++j) {
      // Sizes fill their class evenly.
      const double over = (relative + (j - above) * kStep) / kStep + 0.5;
      seen_[i] += hits[j] * std::clamp(over, 0.0, 1.0);
    }
  }
  const double most = seen_.back();
  if (!(most > 0)) {
    seen_.clear();
    return;
  }
  for (double& v : seen_) v /= most;
}

void SizeSelection::apply(std::vector<CutProfile>& sections) const {
  if (sections.empty()) return;
  if (seen_.empty()) {
    drop_small(sections, smallest_);
    const double scale = mean_ / mean_root_area(sections);
    for (CutProfile& s : sections) s.scale = scale;
    return;
  }
  const double mean = mean_root_area(sections), last = static_cast<double>(seen_.size()) - 1;
  const auto seen_at = [&](double at) {
    const auto k = std::min<std::size_t>(at, seen_.size() - 2);
    const double t = at - k;
    return (1 - t) * seen_[k] + t * seen_[k + 1];
  };
  std::size_t number = 0;
  std::erase_if(sections, [&](CutProfile& s) {
    ++number;
    const double relative = std::log(s.root_area / mean);
    const double at = std::clamp((relative - first_) / kStep, 0.0, last), seen = seen_at(at);
    if (!(seen > 1e-4)) return true;
    s.weight *= seen;
    // A particle whose mean section is e^size times the limit shows this section above the limit if it shows
    // sections of the relative size −size; those above a size are as many as seen_ at its negative.
    const double share = seen * std::fmod(0.5 + 0.6180339887498949 * number, 1.0);
    const std::size_t k =
        std::upper_bound(seen_.begin(), seen_.end(), share) - seen_.begin();  // seen_[k − 1] ≤ share
    double where = k;
    if (k > 0 && k < seen_.size()) where -= (seen_[k] - share) / (seen_[k] - seen_[k - 1]);
    const double size = -(first_ + std::min(where, at) * kStep);
    s.scale = limit_ * std::exp(size) / mean;
    return false;
  });
}

}  // namespace terrazzo::shape_estimate

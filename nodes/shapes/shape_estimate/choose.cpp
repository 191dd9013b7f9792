#include "nodes/shapes/shape_estimate/choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/rank.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {

namespace {

using Features = std::array<double, 4>;
constexpr std::size_t kConvexity = 2;

constexpr double kNearlyWhole = 0.85;  // share of a silhouette that must be visible
constexpr std::size_t kMost = 1500;    // candidates; the choice is quadratic in their number

// Standardizes each feature: zero mean, unit standard deviation.
std::vector<Features> features_of(const std::vector<Outline>& outlines) {
  std::vector<Features> f;
  for (const auto& o : outlines)
    f.push_back({o.circularity, o.aspect, o.convexity, std::min(o.corners, 8) / 4.0});
  for (std::size_t k = 0; k < 4; ++k) {
    double mean = 0, square = 0;
    for (const auto& v : f) mean += v[k] / f.size();
    for (const auto& v : f) square += (v[k] - mean) * (v[k] - mean) / f.size();
    for (auto& v : f) v[k] = square > 1e-12 ? (v[k] - mean) / std::sqrt(square) : 0;
  }
  return f;
}

double distance(const Features& a, const Features& b) {
  double d = 0;
  for (std::size_t k = 0; k < a.size(); ++k) d += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(d);
}

// The profile with the smallest weighted sum of distances to all members.
int medoid(const std::vector<Features>& f, const std::vector<double>& weight, const std::vector<int>& members,
           const Work& work) {
  int best = members[0];
  double least = std::numeric_limits<double>::infinity();
  for (const int i : members) {
    work.check();
    double sum = 0;
    for (const int j : members) sum += weight[j] * distance(f[i], f[j]);
    if (sum < least) {
      least = sum;
      best = i;
    }
  }
  return best;
}

std::vector<int> farthest_first(const std::vector<Features>& f, const std::vector<double>& weight,
                                std::size_t k, const Work& work) {
  std::vector<int> all(f.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<int> chosen{medoid(f, weight, all, work)};
  std::vector<double> gap(f.size(), std::numeric_limits<double>::infinity());
  while (chosen.size() < k) {
    int best = -1;
    for (std::size_t i = 0; i < f.size(); ++i) {
      gap[i] = std::min(gap[i], distance(f[i], f[chosen.back()]));
      if (std::find(chosen.begin(), chosen.end(), static_cast<int>(i)) != chosen.end()) continue;
      if (best < 0 || gap[i] > gap[best]) best = i;
    }
    chosen.push_back(best);
  }
  return chosen;
}

std::vector<int> medoids(const std::vector<Features>& f, const std::vector<double>& weight, std::size_t k,
                         std::uint64_t seed, const Work& work) {
  std::vector<int> all(f.size());
  std::iota(all.begin(), all.end(), 0);
  // Profiles that were merged or frayed by segmentation are among the least convex of any material.
  std::stable_sort(all.begin(), all.end(), [&](int a, int b) { return f[a][kConvexity] > f[b][kConvexity]; });
  all.resize(std::max(k, all.size() - all.size() / 3));
  const int common = medoid(f, weight, all, work);
  std::stable_sort(all.begin(), all.end(),
                   [&](int a, int b) { return distance(f[a], f[common]) < distance(f[b], f[common]); });
  all.resize(std::max(k, all.size() - all.size() / 8));
  // Initialize with k-means++, so that one cluster does not receive all starting points.
  Random r(seed, 201);
  std::vector<int> chosen{all[r.below(all.size())]};
  std::vector<double> gap(f.size(), std::numeric_limits<double>::infinity());
  const auto taken = [&](int i) { return std::find(chosen.begin(), chosen.end(), i) != chosen.end(); };
  while (chosen.size() < k) {
    double total = 0;
    for (const int i : all) {
      const double d = distance(f[i], f[chosen.back()]);
      gap[i] = std::min(gap[i], weight[i] * d * d);
      total += gap[i];
    }
    double at = r.uniform() * total;
    int next = -1;
    for (const int i : all)
      if (next < 0 && gap[i] > 0 && (at -= gap[i]) <= 0) next = i;
    for (const int i : all)  // equal features: any remaining profile
      if (next < 0 && !taken(i)) next = i;
    chosen.push_back(next);
  }
  for (int round = 0; round < 30; ++round) {
    std::vector<std::vector<int>> members(k);
    for (const int i : all) {
      std::size_t best = 0;
      for (std::size_t c = 0; c < k; ++c)
        if (chosen[c] == i ||
            (chosen[best] != i && distance(f[i], f[chosen[c]]) < distance(f[i], f[chosen[best]])))
          best = c;
      members[best].push_back(i);
    }
    bool changed = false;
    for (std::size_t c = 0; c < k; ++c) {
      const int m = medoid(f, weight, members[c], work);
      changed = changed || m != chosen[c];
      chosen[c] = m;
    }
    if (!changed) break;
  }
  return chosen;
}

// The outline of median convexity of each of `wanted` groups of similar size, which cover about the same
// area: outlines that were merged or frayed by segmentation are less convex.
std::vector<int> one_of_each_size(const std::vector<Outline>& outlines, std::size_t wanted) {
  double left = 0;
  for (const Outline& o : outlines) left += o.area;
  std::vector<int> chosen;
  std::size_t next = 0;
  for (std::size_t group = 0; group < wanted; ++group) {
    const double share = left / (wanted - group);
    const std::size_t last = outlines.size() - (wanted - group - 1);  // one for each of the other groups
    std::vector<std::pair<double, int>> own;
    for (double sum = 0; next < last && (own.empty() || sum + outlines[next].area / 2 < share); ++next) {
      own.emplace_back(outlines[next].convexity, static_cast<int>(next));
      sum += outlines[next].area;
      left -= outlines[next].area;
    }
    chosen.push_back(median(std::move(own)).second);
  }
  return chosen;
}

}  // namespace

std::string Candidates::text() const {
  std::string parts = fmt::format("{} usable", outlines.size());
  const auto add = [&](int n, const char* what) {
    if (n) parts += fmt::format(", {} {}", n, what);
  };
  add(without_contour, "without a contour");
  add(cut_by_border, "cut by the border");
  add(hidden, "partly hidden by others");
  add(too_small, "too small");
  add(faulty, "with a contour that crosses itself or encloses no area");
  add(other_class, "of other classes");
  add(other_form, "not compact");
  return parts;
}

Candidates candidates_of(const Profiles& profiles, const CandidateOptions& options, const Work& work) {
  Candidates out;
  struct Open {
    int id;
    const Profile* profile;
    double area, step;
  };
  std::vector<Open> open;
  for (std::size_t i = 0; i < profiles.profiles.size(); ++i) {
    const Profile& p = profiles.profiles[i];
    if (options.cls >= 0 && p.cls != options.cls) {
      ++out.other_class;
    } else if (p.contour.empty()) {
      ++out.without_contour;
    } else if (p.touches_border) {
      ++out.cut_by_border;
    } else if (profiles.view == View::Surface && p.area < kNearlyWhole * p.whole) {
      ++out.hidden;
    } else {
      double area = 0;
      std::vector<double> steps;
      for (std::size_t k = 0; k < p.contour.size(); ++k) {
        const Vec2 a = p.contour[k] - p.contour[0], b = p.contour[(k + 1) % p.contour.size()] - p.contour[0];
        area += (a.x() * b.y() - a.y() * b.x()) / 2;
        steps.push_back((b - a).norm());
      }
      std::nth_element(steps.begin(), steps.begin() + (steps.size() / 2), steps.end());
      if (std::isfinite(area)) {
        open.push_back({static_cast<int>(i) + 1, &p, std::abs(area), steps[steps.size() / 2]});
      } else {
        ++out.faulty;
      }
    }
  }
  std::stable_sort(open.begin(), open.end(), [](const Open& a, const Open& b) { return a.area > b.area; });
  if (open.empty()) return out;
  const std::size_t larger = (open.size() + 3) / 4;
  std::size_t fine = 0;
  for (std::size_t i = 0; i < larger; ++i) fine += open[i].profile->contour.size() >= 24;
  const bool pixels = 2 * fine >= larger;
  if (pixels) {
    const auto small = [](const Open& o) { return o.area < 30 * o.step * o.step; };
    out.too_small += static_cast<int>(std::erase_if(open, small));
    if (open.empty()) return out;
  }
  // The reference size is that of the largest decile: particles that grew together are larger than any.
  const double large = open[open.size() / 10].area, least = options.smallest * options.smallest * large;
  for (const auto& o : open) {
    work.check();
    if (o.area < least || out.outlines.size() == kMost) {
      ++out.too_small;
    } else if (std::binary_search(options.without.begin(), options.without.end(), o.id)) {
      ++out.other_form;
    } else if (!outline_fault(o.profile->contour).empty()) {
      ++out.faulty;
    } else {
      out.outlines.push_back(make_outline(o.id, o.profile->contour, options.crease));
    }
  }
  return out;
}

std::vector<Outline> outlines_by_id(const Profiles& profiles, const std::vector<std::int64_t>& ids,
                                    double crease) {
  std::vector<Outline> out;
  for (const auto id : ids) {
    if (id < 1 || id > static_cast<std::int64_t>(profiles.profiles.size()))
      throw Error("bad-profile", fmt::format("there is no profile {}", id),
                  fmt::format("use ids from 1 to {}", profiles.profiles.size()));
    const auto& contour = profiles.profiles[id - 1].contour;
    if (const auto fault = outline_fault(contour); !fault.empty())
      throw Error("bad-profile", fmt::format("profile {} cannot be used: {}", id, fault),
                  "choose another profile");
    out.push_back(make_outline(id, contour, crease));
  }
  return out;
}

std::vector<std::vector<int>> choose_profiles(const std::vector<Outline>& outlines, const std::string& rule,
                                              std::size_t shapes, std::size_t each, std::uint64_t seed,
                                              const Work& work) {
  const std::size_t wanted = std::min(shapes * each, outlines.size());
  std::vector<int> chosen;
  if (rule == "largest") {
    chosen.resize(wanted);
    std::iota(chosen.begin(), chosen.end(), 0);
  } else if (rule == "each_size") {
    chosen = one_of_each_size(outlines, wanted);
  } else {
    const auto f = features_of(outlines);
    std::vector<double> weight;
    for (const auto& o : outlines) weight.push_back(std::sqrt(o.area));
    chosen =
        rule == "diverse" ? farthest_first(f, weight, wanted, work) : medoids(f, weight, wanted, seed, work);
  }
  // Sort by decreasing aspect ratio, then deal out, so that each shape gets rounder and longer profiles.
  std::stable_sort(chosen.begin(), chosen.end(),
                   [&](int a, int b) { return outlines[a].aspect > outlines[b].aspect; });
  std::vector<std::vector<int>> hands(shapes);
  Random r(seed, 202);
  std::vector<std::size_t> order(shapes);
  for (std::size_t k = 0; k < each; ++k) {
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = shapes; i > 1; --i) std::swap(order[i - 1], order[r.below(i)]);
    for (std::size_t s = 0; s < shapes; ++s) {
      const std::size_t at = k * shapes + s;
      if (at < chosen.size()) {
        hands[order[s]].push_back(chosen[at]);
        continue;
      }
      // Not enough for all: reuse a profile that this shape does not have yet, if there is one.
      for (std::size_t tries = 0, i = r.below(chosen.size());; ++tries, i = (i + 1) % chosen.size()) {
        auto& hand = hands[order[s]];
        if (tries < chosen.size() && std::find(hand.begin(), hand.end(), chosen[i]) != hand.end()) continue;
        hand.push_back(chosen[i]);
        break;
      }
    }
  }
  return hands;
}

}  // namespace terrazzo::shape_estimate

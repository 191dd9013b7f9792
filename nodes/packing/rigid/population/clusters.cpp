#include "nodes/packing/rigid/population/clusters.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/loop.h"
#include "runtime/random.h"

namespace terrazzo::packing {
namespace {

constexpr std::uint64_t kReference = 0x7265666572656e63, kThin = 0x7468696e;
constexpr std::size_t kMostPoints = 1200;         // random points and small profiles of a section, at most
constexpr std::size_t kFewestSmall = 20;          // small profiles of all sections
constexpr double kPairBin = 0.5, kFarPairs = 10;  // bins of distances, and the largest, in `below`
constexpr double kNearPairs = 4;        // distances that decide whether there are clusters, in `below`
constexpr double kSurelyClustered = 6;  // standard deviations of the number of near pairs

struct Outline {
  Loop loop;
  Vec2 low, high;
  bool contains(const Vec2& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all() && loop_contains(loop, p);
  }
};

struct Section {
  std::vector<Vec2> small;
  std::vector<Outline> large;
};

double size_of(const Profile& p) { return std::sqrt(4 / std::numbers::pi * p.area); }

std::vector<Section> sections_of(const Profiles& profiles, double below) {
  std::vector<Section> out(std::max(1, profiles.sections));
  for (const Profile& p : profiles.profiles) {
    if (p.section < 0 || p.section >= static_cast<int>(out.size())) continue;
    if (size_of(p) <= below) {
      out[p.section].small.push_back(p.centroid);
    } else {
      if (p.contour.size() < 3) return {};  // where small ones may lie is unknown
      Outline o{p.contour, p.contour[0], p.contour[0]};
      for (const Vec2& v : p.contour) {
        o.low = o.low.cwiseMin(v);
        o.high = o.high.cwiseMax(v);
      }
      out[p.section].large.push_back(std::move(o));
    }
  }
  return out;
}

// Random points outside of the large profiles.
std::vector<Vec2> free_points(const Section& s, const Vec2& window, std::size_t section) {
  Random random(1, kReference, section);
  std::vector<Vec2> out;
  for (std::size_t tries = 0; out.size() < kMostPoints && tries < 20 * kMostPoints; ++tries) {
    const Vec2 p(random.uniform() * window.x(), random.uniform() * window.y());
    if (std::none_of(s.large.begin(), s.large.end(), [&](const Outline& o) { return o.contains(p); }))
      out.push_back(p);
  }
  return out;
}

// A random part of the points leaves their pair correlation as it is.
std::vector<Vec2> thinned(std::vector<Vec2> points, std::size_t section) {
  Random random(1, kThin, section);
  for (std::size_t i = 0; i < points.size() && i < kMostPoints; ++i)
    std::swap(points[i], points[i + random.below(points.size() - i)]);
  if (points.size() > kMostPoints) points.resize(kMostPoints);
  return points;
}

void count_pairs(const std::vector<Vec2>& points, double bin, double weight, std::vector<double>& pairs) {
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const auto at = static_cast<std::size_t>((points[i] - points[k]).norm() / bin);
      if (at < pairs.size()) pairs[at] += weight;
    }
}

double pairs_among(double n) { return 0.5 * n * (n - 1); }

// Pairs of small profiles by distance, and those expected of random points.
struct Pairs {
  double below = 0;
  std::size_t profiles = 0;
  std::vector<double> found, expected;

  // How many standard deviations of chance there are more near pairs than expected.
  double surplus() const {
    double more = 0, all = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(kNearPairs / kPairBin); ++k) {
      more += found[k] - expected[k];
      all += expected[k];
    }
    return all > 0 ? more / std::sqrt(all) : 0;
  }
};

Pairs pairs_below(const Profiles& profiles, double below, const Work& work) {
  Pairs out;
  out.below = below;
  out.found.assign(static_cast<std::size_t>(kFarPairs / kPairBin), 0);
  out.expected = out.found;
  const auto sections = sections_of(profiles, below);
  for (std::size_t s = 0; s < sections.size(); ++s) {
    work.check();
    const auto small = thinned(sections[s].small, s);
    const auto random = free_points(sections[s], profiles.window, s);
    if (random.size() < 2) continue;
    out.profiles += small.size();
    count_pairs(small, kPairBin * below, 1, out.found);
    count_pairs(
        random, kPairBin * below,
        pairs_among(static_cast<double>(small.size())) / pairs_among(static_cast<double>(random.size())),
        out.expected);
  }
  return out;
}

// Least squares, weighted by the inverse variance of random points. Distances below one size are left out:
// there, profiles exclude each other.
Clusters fitted(const Pairs& pairs) {
  Clusters best;
  best.below = pairs.below;
  double least = 1e300;
  for (double spread = 0.5; spread <= 5; spread *= 1.05) {
    double with = 0, square = 0;
    const auto shape = [&](std::size_t k) {
      const double r = (static_cast<double>(k) + 0.5) * kPairBin / spread;
      return std::exp(-0.25 * r * r);
    };
    const auto first = static_cast<std::size_t>(1 / kPairBin);
    for (std::size_t k = first; k < pairs.found.size(); ++k) {
      with += shape(k) * (pairs.found[k] - pairs.expected[k]);
      square += shape(k) * shape(k) * pairs.expected[k];
    }
    if (!(square > 0)) continue;
    const double excess = with / square;
    double misfit = 0;
    for (std::size_t k = first; k < pairs.found.size(); ++k)
      if (pairs.expected[k] > 0)
        misfit +=
            std::pow(pairs.found[k] - pairs.expected[k] * (1 + excess * shape(k)), 2) / pairs.expected[k];
    if (misfit >= least) continue;
    least = misfit;
    best.spread = spread * pairs.below;
    best.excess = excess;
  }
  return best;
}

}  // namespace

double Clusters::per_volume() const {
  return 1 / (excess * std::pow(4 * std::numbers::pi * spread * spread, 1.5));
}

Clusters measure_clusters(const Profiles& profiles, const Work& work) {
  if (profiles.view != View::Section || !(profiles.window.minCoeff() > 0)) return {};
  std::vector<double> sizes;
  for (const Profile& p : profiles.profiles) sizes.push_back(size_of(p));
  std::sort(sizes.begin(), sizes.end());
  Pairs most;
  double surplus = kSurelyClustered;
  for (int tenth = 3; tenth <= 9; ++tenth) {
    const std::size_t rank = sizes.size() * static_cast<std::size_t>(tenth) / 10;
    if (rank < kFewestSmall || !(sizes[rank] > 0)) continue;
    Pairs pairs = pairs_below(profiles, sizes[rank], work);
    if (pairs.profiles < kFewestSmall || pairs.surplus() <= surplus) continue;
    surplus = pairs.surplus();
    most = std::move(pairs);
  }
  if (most.below == 0) return {};
  const Clusters clusters = fitted(most);
  return clusters.excess > 0 && clusters.spread > 0 ? clusters : Clusters{};
}

}  // namespace terrazzo::packing

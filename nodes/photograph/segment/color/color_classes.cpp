#include "nodes/photograph/segment/color/color_classes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "nodes/common/geometry/mesh/loop.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/kmeans.h"

namespace terrazzo::segment {
namespace {

constexpr int kMost = 8;
constexpr double kLeastSilhouette = 0.5;  // even one shapeless cloud that is cut into parts reaches it
constexpr std::size_t kLeastProfiles = 30;
constexpr double kSurely = 0.001;

// What is known about the particles of a cluster: measures of its complete profiles, sorted.
struct Cluster {
  std::vector<int> parts;  // indices of the clusters that it was joined from
  double weight = 0;       // number of profiles
  Vec3 color = Vec3::Zero();
  std::vector<double> sizes, circularities;
};

// Profiles of fewer points than `kLeastPoints` have no circularity to speak of.
std::vector<Cluster> measured(const Profiles& profiles, const ColorClusters& found) {
  constexpr std::size_t kLeastPoints = 12;
  std::vector<Cluster> out(found.k);
  for (int c = 0; c < found.k; ++c) {
    out[c].parts = {c};
    out[c].color = found.mean[c];
  }
  for (std::size_t i = 0; i < profiles.profiles.size(); ++i) {
    const Profile& p = profiles.profiles[i];
    Cluster& c = out[found.of[i]];
    ++c.weight;
    if (p.touches_border) continue;
    c.sizes.push_back(std::sqrt(p.area));
    if (p.contour.size() < kLeastPoints) continue;
    const double length = loop_perimeter(p.contour);
    c.circularities.push_back(4 * std::numbers::pi * p.area / (length * length));
  }
  for (Cluster& c : out) {
    std::sort(c.sizes.begin(), c.sizes.end());
    std::sort(c.circularities.begin(), c.circularities.end());
  }
  return out;
}

void join(Cluster& into, Cluster& from) {
  into.color = (into.weight * into.color + from.weight * from.color) / (into.weight + from.weight);
  into.weight += from.weight;
  const auto merge = [](auto& a, auto& b) {
    a.insert(a.end(), b.begin(), b.end());
    std::sort(a.begin(), a.end());
  };
  merge(into.sizes, from.sizes);
  merge(into.circularities, from.circularities);
  into.parts.insert(into.parts.end(), from.parts.begin(), from.parts.end());
}

// Bonferroni: two tests.
double likeness(const Cluster& a, const Cluster& b) {
  return 2 *
         std::min(kolmogorov_smirnov(a.sizes, b.sizes), kolmogorov_smirnov(a.circularities, b.circularities));
}

// Joins clusters until all differ. Small ones join the one of the nearest color first.
void join_alike(std::vector<Cluster>& clusters) {
  while (clusters.size() > 1) {
    std::size_t from = 0, into = 0;
    const auto smallest =
        std::min_element(clusters.begin(), clusters.end(),
                         [](const auto& a, const auto& b) { return a.sizes.size() < b.sizes.size(); });
    if (smallest->sizes.size() < kLeastProfiles) {
      from = smallest - clusters.begin();
      double nearest = std::numeric_limits<double>::max();
      for (std::size_t i = 0; i < clusters.size(); ++i)
        if (const double d = (clusters[i].color - smallest->color).norm(); i != from && d < nearest) {
          nearest = d;
          into = i;
        }
    } else {
      double most = kSurely;
      for (std::size_t i = 0; i < clusters.size(); ++i)
        for (std::size_t j = i + 1; j < clusters.size(); ++j)
          if (const double p = likeness(clusters[i], clusters[j]); p > most) {
            most = p;
            into = i;
            from = j;
          }
      if (from == into) return;
    }
    join(clusters[into], clusters[from]);
    clusters.erase(clusters.begin() + from);
  }
}

}  // namespace

double kolmogorov_smirnov(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.empty() || b.empty()) return 1;
  const double n = a.size(), m = b.size();
  double largest = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    const double at = std::min(a[i], b[j]);
    while (i < a.size() && a[i] <= at) ++i;
    while (j < b.size() && b[j] <= at) ++j;
    largest = std::max(largest, std::abs(i / n - j / m));
  }
  const double root = std::sqrt(n * m / (n + m)), x = (root + 0.12 + 0.11 / root) * largest;
  if (x < 0.3) return 1;  // the series converges slowly there, and its sum is 1 to five digits
  double sum = 0, sign = 1;
  for (int k = 1; k <= 100; ++k, sign = -sign) sum += sign * std::exp(-2 * x * x * k * k);
  return std::clamp(2 * sum, 0.0, 1.0);
}

std::vector<int> color_classes(const Profiles& profiles, int k, std::uint64_t seed, const Work& work) {
  std::vector<Vec3> colors;
  for (const Profile& p : profiles.profiles) colors.push_back(linear_to_oklab(p.color).cast<double>());
  const std::vector<double> weights(colors.size(), 1.0);
  ColorClusters found = k > 0 ? kmeans(colors, weights, k, seed, work)
                              : kmeans_auto(colors, weights, kMost, seed, kLeastSilhouette, work);
  if (k > 0) return found.of;
  std::vector<Cluster> clusters = measured(profiles, found);
  join_alike(clusters);
  std::stable_sort(clusters.begin(), clusters.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  std::vector<int> number(found.k, 0), out;
  for (std::size_t c = 0; c < clusters.size(); ++c)
    for (const int part : clusters[c].parts) number[part] = c;
  for (const int c : found.of) out.push_back(number[c]);
  return out;
}

}  // namespace terrazzo::segment

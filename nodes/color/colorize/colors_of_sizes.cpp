#include "nodes/color/colorize/colors_of_sizes.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/common/texture/kmeans.h"

namespace terrazzo::colorize {
namespace {

constexpr int kClusters = 16, kRounds = 40;
constexpr std::size_t kBins = 24;  // of sizes, geometric
// Colors change little from bin to bin: after each round, those of neighbors are averaged with a Gaussian
// (EMS, Silverman et al. 1990), in bins.
constexpr double kSmooth = 1.5;
// Number of profiles that the colors of all sizes together count for, where a bin and its neighbors show
// none.
constexpr double kPrior = 0.02;

// How well a profile stands for a particle: its likelihood, times its share of the particle's size, because
// photographs show stones whole or leave out the small ends that planes cut off.
double evidence(double profile, double size) {
  return profile_likelihood(profile, size) * std::min(1.0, profile / size);
}

}  // namespace

double profile_likelihood(double profile, double size) {
  // P(diameter ≤ p) = 1 − √(1 − (p/s)²) over the depths of a plane that meets a sphere.
  const auto below = [&](double p) {
    const double t = std::clamp(p / size, 0.0, 1.0);
    return 1 - std::sqrt(1 - t * t);
  };
  return below(profile + 0.05 * size) - below(profile - 0.05 * size);
}

namespace {

// The shares of clusters in a bin and those near it. `from`: counts by bin and cluster. `all`: the shares in
// all bins, to which few counts are drawn.
std::vector<double> smooth_shares(std::size_t bin, const std::vector<std::vector<double>>& from,
                                  const std::vector<double>& all) {
  std::vector<double> near(all.size(), 0);
  double sum = 0;
  for (std::size_t d = 0; d < from.size(); ++d) {
    const double apart = (static_cast<double>(bin) - d) / kSmooth;
    const double part = std::exp(-0.5 * apart * apart);
    for (std::size_t c = 0; c < all.size(); ++c) {
      near[c] += part * from[d][c];
      sum += part * from[d][c];
    }
  }
  std::vector<double> share;
  for (std::size_t c = 0; c < all.size(); ++c) share.push_back((near[c] + kPrior * all[c]) / (sum + kPrior));
  return share;
}

}  // namespace

ColorsOfSizes::ColorsOfSizes(const std::vector<ColoredProfile>& profiles, const std::vector<double>& sizes,
                             std::uint64_t seed, const Work& work)
    : profiles_(profiles), expected_(profiles.size(), 0) {
  std::vector<Vec3> lab;
  std::vector<double> weights;
  for (const ColoredProfile& p : profiles) {
    lab.push_back(linear_to_oklab(p.color).cast<double>());
    weights.push_back(p.weight);
  }
  const int most = std::min(kClusters, std::max<int>(1, profiles.size() / 3));
  ColorClusters found = kmeans(lab, weights, most, seed, work.quiet());
  cluster_ = std::move(found.of);
  const std::size_t clusters = found.k;

  const auto [low, high] = std::minmax_element(sizes.begin(), sizes.end());
  smallest_ = *low;
  ratio_ = std::max(1 + 1e-9, std::pow(*high / *low, 1.0 / kBins));
  std::vector<double> count(kBins, 0), middle(kBins, 0);
  for (const double s : sizes) {
    ++count[bin_of(s)];
    middle[bin_of(s)] += s;
  }
  for (std::size_t b = 0; b < kBins; ++b)
    if (count[b] > 0) middle[b] /= count[b];
  // The number of particles of each bin that are expected to show such a profile.
  std::vector<std::vector<double>> shown(profiles.size(), std::vector<double>(kBins, 0));
  std::vector<double> all(clusters, 0);
  double total = 0;
  for (std::size_t i = 0; i < profiles.size(); ++i) {
    for (std::size_t b = 0; b < kBins; ++b)
      if (count[b] > 0) shown[i][b] = count[b] * evidence(profiles[i].size, middle[b]);
    all[cluster_[i]] += profiles[i].weight;
    total += profiles[i].weight;
  }
  for (double& a : all) a /= total;
  share_.assign(kBins, std::vector<double>(clusters, 1));
  const auto expect = [&](std::size_t i) {
    double sum = 0;
    for (std::size_t b = 0; b < kBins; ++b) sum += shown[i][b] * share_[b][cluster_[i]];
    return sum;
  };
  const double of_one = profiles.size() / total;  // number of profiles per weight
  for (int round = 0; round < kRounds; ++round) {
    work.check();
    std::vector<std::vector<double>> from(kBins, std::vector<double>(clusters, 0));
    for (std::size_t i = 0; i < profiles.size(); ++i) {
      const std::size_t c = cluster_[i];
      const double sum = expect(i);
      if (!(sum > 0)) continue;
      for (std::size_t b = 0; b < kBins; ++b)
        from[b][c] += profiles[i].weight * of_one * shown[i][b] * share_[b][c] / sum;
    }
    for (std::size_t b = 0; b < kBins; ++b) share_[b] = smooth_shares(b, from, all);
  }
  work.parallel(profiles.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (const double s : sizes)
        expected_[i] += evidence(profiles[i].size, s) * share_[bin_of(s)][cluster_[i]];
  });
}

std::size_t ColorsOfSizes::bin_of(double size) const {
  const double at = std::log(std::max(1.0, size / smallest_)) / std::log(ratio_);
  return std::min<std::size_t>(kBins - 1, at);
}

double ColorsOfSizes::weight(std::size_t profile, double size) const {
  if (!(expected_[profile] > 0)) return 0;
  return profiles_[profile].weight * evidence(profiles_[profile].size, size) *
         share_[bin_of(size)][cluster_[profile]] / expected_[profile];
}

}  // namespace terrazzo::colorize

#include "nodes/common/texture/kmeans.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {

double distance2(const Vec3& a, const Vec3& b) { return (a - b).squaredNorm(); }

int nearest(const std::vector<Vec3>& means, const Vec3& p) {
  int best = 0;
  for (int c = 1; c < count_of(means); ++c)
    if (distance2(means[c], p) < distance2(means[best], p)) best = c;
  return best;
}

std::vector<Vec3> plus_plus(const std::vector<Vec3>& points, const std::vector<double>& weights, int k,
                            Random random) {
  std::vector<Vec3> means;
  std::vector<double> chance = weights;
  while (count_of(means) < k) {
    const double total = std::accumulate(chance.begin(), chance.end(), 0.0);
    if (total <= 0) break;  // no more distinct points
    double at = random.uniform() * total;
    std::size_t pick = 0, last = 0;
    for (; pick < points.size(); ++pick) {
      if (chance[pick] > 0) last = pick;
      if ((at -= chance[pick]) < 0) break;
    }
    means.push_back(points[std::min(pick, last)]);
    for (std::size_t i = 0; i < points.size(); ++i) {
      double d = std::numeric_limits<double>::max();
      for (const auto& m : means) d = std::min(d, distance2(m, points[i]));
      chance[i] = weights[i] * d;
    }
  }
  return means;
}

double lloyd(const std::vector<Vec3>& points, const std::vector<double>& weights, std::vector<Vec3>& means,
             std::vector<int>& of) {
  of.assign(points.size(), -1);
  for (int round = 0; round < 100; ++round) {
    bool changed = false;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const int c = nearest(means, points[i]);
      changed |= c != of[i];
      of[i] = c;
    }
    if (!changed) break;
    std::vector<Vec3> sum(means.size(), Vec3::Zero());
    std::vector<double> mass(means.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
      sum[of[i]] += weights[i] * points[i];
      mass[of[i]] += weights[i];
    }
    for (std::size_t c = 0; c < means.size(); ++c)
      if (mass[c] > 0) means[c] = sum[c] / mass[c];
  }
  double cost = 0;
  for (std::size_t i = 0; i < points.size(); ++i) cost += weights[i] * distance2(means[of[i]], points[i]);
  return cost;
}

double silhouette(const std::vector<Vec3>& points, const ColorClusters& clusters) {
  if (clusters.k < 2) return 0;
  const std::size_t step = (points.size() + 999) / 1000;
  std::vector<std::size_t> sample;
  for (std::size_t i = 0; i < points.size(); i += step) sample.push_back(i);
  double total = 0;
  for (const auto i : sample) {
    std::vector<double> sum(clusters.k, 0), count(clusters.k, 0);
    for (const auto j : sample)
      if (j != i) {
        sum[clusters.of[j]] += (points[i] - points[j]).norm();
        ++count[clusters.of[j]];
      }
    const int own = clusters.of[i];
    if (count[own] == 0) continue;  // alone in its cluster: 0 by definition
    double other = std::numeric_limits<double>::max();
    for (int c = 0; c < clusters.k; ++c)
      if (c != own && count[c] > 0) other = std::min(other, sum[c] / count[c]);
    const double a = sum[own] / count[own];
    if (other < std::numeric_limits<double>::max() && std::max(a, other) > 0)
      total += (other - a) / std::max(a, other);
  }
  return total / sample.size();
}

}  // namespace

ColorClusters kmeans(const std::vector<Vec3>& points, const std::vector<double>& weights, int k,
                     std::uint64_t seed, const Work& work) {
  ColorClusters best;
  double best_cost = std::numeric_limits<double>::max();
  for (int start = 0; start < 8; ++start) {
    work.check();
    std::vector<Vec3> means = plus_plus(points, weights, k, Random(seed, 0x6b6d, start));
    std::vector<int> of;
    const double cost = lloyd(points, weights, means, of);
    if (cost < best_cost) {
      best_cost = cost;
      best.mean = std::move(means);
      best.of = std::move(of);
    }
  }
  // Sort clusters by decreasing weight, so that the numbering does not depend on the winning start.
  best.k = best.mean.size();
  std::vector<double> mass(best.k, 0);
  for (std::size_t i = 0; i < points.size(); ++i) mass[best.of[i]] += weights[i];
  std::vector<int> order(best.k), rank(best.k);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return mass[a] > mass[b]; });
  std::vector<Vec3> means;
  for (int c = 0; c < best.k; ++c) {
    rank[order[c]] = c;
    means.push_back(best.mean[order[c]]);
  }
  for (int& c : best.of) c = rank[c];
  best.mean = std::move(means);
  best.silhouette = silhouette(points, best);
  return best;
}

ColorClusters kmeans_auto(const std::vector<Vec3>& points, const std::vector<double>& weights, int max_k,
                          std::uint64_t seed, double least, const Work& work) {
  ColorClusters best = kmeans(points, weights, 1, seed, work);
  double bar = least;
  for (int k = 2; k <= max_k && k < count_of(points); ++k) {
    ColorClusters candidate = kmeans(points, weights, k, seed, work);
    if (candidate.k == k && candidate.silhouette > bar) {
      bar = candidate.silhouette;
      best = std::move(candidate);
    }
  }
  return best;
}

}  // namespace terrazzo

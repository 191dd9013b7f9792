#include "nodes/photograph/segment/color/clustering.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::segment {
namespace {

std::vector<Vec3f> plus_plus(const std::vector<Vec3f>& points, int k, Random& random) {
  std::vector<Vec3f> centers{points[random.below(points.size())]};
  std::vector<float> distance(points.size(), std::numeric_limits<float>::max());
  while (count_of(centers) < k) {
    double total = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      distance[i] = std::min(distance[i], (points[i] - centers.back()).squaredNorm());
      total += distance[i];
    }
    if (total <= 0) break;
    double at = random.uniform() * total;
    std::size_t i = 0;
    while (i + 1 < points.size() && (at -= distance[i]) > 0) ++i;
    if (distance[i] <= 0) break;
    centers.push_back(points[i]);
  }
  return centers;
}

double lloyd(const std::vector<Vec3f>& points, std::vector<Vec3f>& centers, const Work& work) {
  double inertia = std::numeric_limits<double>::max();
  for (int round = 0; round < 60; ++round) {
    work.check();
    std::vector<Eigen::Vector3d> sums(centers.size(), Eigen::Vector3d::Zero());
    std::vector<std::size_t> counts(centers.size(), 0);
    double now = 0;
    for (const auto& p : points) {
      std::size_t best = 0;
      float d = std::numeric_limits<float>::max();
      for (std::size_t c = 0; c < centers.size(); ++c)
        if (const float e = (p - centers[c]).squaredNorm(); e < d) {
          d = e;
          best = c;
        }
      sums[best] += p.cast<double>();
      ++counts[best];
      now += d;
    }
    now /= points.size();
    for (std::size_t c = 0; c < centers.size(); ++c)
      if (counts[c] > 0) centers[c] = (sums[c] / static_cast<double>(counts[c])).cast<float>();
    if (now >= inertia * (1 - 1e-5)) return now;
    inertia = now;
  }
  return inertia;
}

}  // namespace

int Clusters::nearest(const Vec3f& p) const {
  int best = 0;
  float d = std::numeric_limits<float>::max();
  for (std::size_t c = 0; c < centers.size(); ++c)
    if (const float e = (p - centers[c]).squaredNorm(); e < d) {
      d = e;
      best = c;
    }
  return best;
}

Clusters k_means(const std::vector<Vec3f>& points, int k, std::uint64_t seed, const Work& work) {
  Clusters out;
  if (points.empty() || k < 1) return out;
  out.inertia = std::numeric_limits<double>::max();
  for (std::uint64_t start = 0; start < 4; ++start) {
    Random random(seed, static_cast<std::uint64_t>(k), start);
    auto centers = plus_plus(points, k, random);
    const double inertia = lloyd(points, centers, work);
    if (inertia < out.inertia) {
      out.inertia = inertia;
      out.centers = std::move(centers);
    }
  }
  std::sort(out.centers.begin(), out.centers.end(), [](const Vec3f& a, const Vec3f& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  });
  const std::size_t n = out.centers.size();
  out.weights.assign(n, 0);
  std::vector<double> squares(n, 0), counts(n, 0);
  double silhouette = 0;
  for (const auto& p : points) {
    float first = std::numeric_limits<float>::max(), second = first;
    std::size_t best = 0;
    for (std::size_t c = 0; c < n; ++c) {
      const float d = (p - out.centers[c]).squaredNorm();
      if (d < first) {
        second = first;
        first = d;
        best = c;
      } else
        second = std::min(second, d);
    }
    squares[best] += first;
    counts[best] += 1;
    if (n > 1 && second > 0) silhouette += 1 - std::sqrt(first / second);
  }
  for (std::size_t c = 0; c < n; ++c) {
    out.weights[c] = counts[c] / points.size();
    out.spread.push_back(counts[c] > 0 ? static_cast<float>(std::sqrt(squares[c] / counts[c])) : 0.0f);
  }
  out.silhouette = silhouette / points.size();
  return out;
}

}  // namespace terrazzo::segment

// k-means on colours, with the number of clusters by silhouette.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/work.h"

namespace terrazzo {

struct ColorClusters {
  int k = 1;
  std::vector<int> of;     // cluster of each point, 0 … k − 1; clusters in order of falling total weight
  std::vector<Vec3> mean;  // weighted
  double silhouette = 0;   // mean over at most 1,000 points, −1 … 1; 0 where k = 1
};

// Weighted Lloyd iteration from k-means++ starts (Arthur, Vassilvitskii 2007), the best of 8. `points` in a
// space where distances mean something (Oklab). Fewer distinct points than k give fewer clusters.
ColorClusters kmeans(const std::vector<Vec3>& points, const std::vector<double>& weights, int k,
                     std::uint64_t seed, const Work& work = {});

// The k of 2 … max_k with the largest silhouette (Rousseeuw 1987), or 1 where none reaches `least`: a
// silhouette below 0.5 is reached by one shapeless cloud cut into parts, too.
ColorClusters kmeans_auto(const std::vector<Vec3>& points, const std::vector<double>& weights, int max_k,
                          std::uint64_t seed, double least = 0.5, const Work& work = {});

}  // namespace terrazzo

// k-means clustering of colors, with the number of clusters chosen by silhouette.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo {

struct ColorClusters {
  int k = 1;
  std::vector<int> of;  // cluster of each point, 0 … k − 1; clusters are sorted by decreasing total weight
  std::vector<Vec3> mean;  // weighted means
  double silhouette = 0;   // mean over at most 1,000 points, −1 … 1; 0 if k = 1
};

// The best of 8 weighted Lloyd iterations from k-means++ starts (Arthur, Vassilvitskii 2007). Distances of
// `points` must be perceptually meaningful (Oklab). Fewer distinct points than k yield fewer clusters.
ColorClusters kmeans(const std::vector<Vec3>& points, const std::vector<double>& weights, int k,
                     std::uint64_t seed, const Work& work = {});

// Chooses k from 2 … max_k by the largest silhouette (Rousseeuw 1987), or k = 1 if no silhouette exceeds
// `least`. Even a single shapeless cloud cut into parts reaches silhouettes up to 0.5.
ColorClusters kmeans_auto(const std::vector<Vec3>& points, const std::vector<double>& weights, int max_k,
                          std::uint64_t seed, double least = 0.5, const Work& work = {});

}  // namespace terrazzo

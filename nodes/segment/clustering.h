// Clusters of points in a perceptual colour space.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/linear.h"
#include "runtime/work.h"

namespace terrazzo {

struct Clusters {
  std::vector<Vec3f> centers;  // by rising first coordinate
  std::vector<float> weights;  // shares of the points
  std::vector<float> spread;   // root mean square distance to the centre
  double silhouette = 0;       // mean simplified silhouette: (b − a) / max(a, b), distances to centres
  double inertia = 0;          // mean squared distance to the nearest centre
  int nearest(const Vec3f& p) const;
};

// Lloyd's k-means from the best of several k-means++ starts (Arthur and Vassilvitskii 2007). Gives fewer than
// k clusters where there are fewer different points.
Clusters k_means(const std::vector<Vec3f>& points, int k, std::uint64_t seed, const Work&);

}  // namespace terrazzo

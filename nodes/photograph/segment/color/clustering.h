// Clusters of points in a perceptual color space.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::segment {

struct Clusters {
  std::vector<Vec3f> centers;  // sorted by first coordinate
  std::vector<float> weights;  // shares of the points
  std::vector<float> spread;   // root mean square distance to the center
  double silhouette = 0;       // mean simplified silhouette: (b − a) / max(a, b), from distances to centers
  double inertia = 0;          // mean squared distance to the nearest center
  int nearest(const Vec3f& p) const;
};

// Lloyd's k-means, the best of four k-means++ starts (Arthur and Vassilvitskii 2007). Returns fewer than k
// clusters if there are fewer distinct points. With kmeans() of common/texture, which weights its points, is
// in double precision, stops when no point moves and has another silhouette, nearly every result would
// change.
Clusters k_means(const std::vector<Vec3f>& points, int k, std::uint64_t seed, const Work&);

}  // namespace terrazzo::segment

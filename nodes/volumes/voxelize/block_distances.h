// Distances to a mesh at the points of a small block of a grid.
#pragma once

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/mesh/mesh_distance.h"

namespace terrazzo::voxelize {

constexpr int kBlock = 4;  // largest edge of a block

// Half the diagonal of a block, for points of distance 1.
inline const double kBlockReach = 0.5 * std::sqrt(3.0) * (kBlock - 1);

// Calls store(i, j, k, distance) for lo ≤ (i, j, k) < hi where wanted(i, j, k), with distances of at most
// `band`. `point` maps grid coordinates to those of the mesh, in whose unit half the block's diagonal is
// `reach`. One query at the block's middle detects whether all its points are far from the surface.
template <class Wanted, class Point, class Store>
void block_distances(const Mesh& mesh, const AabbTree& tree, const Vec3i& lo, const Vec3i& hi, double reach,
                     double band, Wanted&& wanted, Point&& point, Store&& store) {
  const Vec3 middle = point(lo.cast<double>() + Vec3::Constant(0.5 * (kBlock - 1)));
  const double limit = band + reach;
  double to_middle = -1;  // not known yet
  for (int k = lo.z(); k < hi.z(); ++k)
    for (int j = lo.y(); j < hi.y(); ++j)
      for (int i = lo.x(); i < hi.x(); ++i) {
        if (!wanted(i, j, k)) continue;
        if (to_middle < 0) to_middle = std::sqrt(squared_distance(mesh, tree, middle, limit * limit));
        double d = band;
        if (to_middle < limit) {
          const Vec3 p = point(Vec3(i, j, k));
          const double bound = std::min(band, to_middle + (p - middle).norm() * (1 + 1e-12));
          d = std::sqrt(squared_distance(mesh, tree, p, bound * bound));
        }
        store(i, j, k, d);
      }
}

}  // namespace terrazzo::voxelize

// The section area of a convex mesh with many triangles, at chosen depths along one direction.
#pragma once

#include <vector>

#include "nodes/common/stereology/depth_areas.h"

namespace terrazzo::kmatrix {

// Cheaper than DepthSweep if there are far more vertices than depths: it sorts nothing, and areas need only
// heights instead of coordinates. By the divergence theorem in the plane, the area of a section is half the
// sum over its chords of length times distance from the origin. A triangle of area T, unit normal n and
// vertex heights z₀ ≤ z₁ ≤ z₂ thus adds T·(n·x − z·n_z)·hat(z)/(z₂ − z₀), where hat rises from 0 at z₀ to 1
// at z₁ and falls to 0 at z₂.
class GridSweep {
 public:
  explicit GridSweep(const Mesh& mesh);
  // Exact at the ends and the middle of every range, quadratic in between; valid until the next call. Range
  // widths shrink quadratically towards both tangent planes, where small profiles come from. Convex bodies
  // only: for others, the areas of several profiles would be added up.
  const std::vector<AreaRange>& sweep(const Vec3& direction);

 private:
  struct Facet {
    std::int32_t a, b, c;
    Vec3 area;      // T·n
    double offset;  // T·n·x
  };
  struct Place {
    double depth;    // share of the height above the lowest vertex
    double ordinal;  // index of its range plus the fraction of the way through it
  };
  std::vector<Vec3> vertex_;
  std::vector<Facet> facets_;
  std::vector<Place> place_;
  std::vector<double> node_depth_, node_area_;  // ends and middles of the ranges, alternating
  std::vector<AreaRange> ranges_;
};

}  // namespace terrazzo::kmatrix

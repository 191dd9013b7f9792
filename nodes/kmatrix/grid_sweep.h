// The section area of a convex mesh of many triangles, at chosen depths of one direction.
#pragma once

#include <vector>

#include "nodes/common/depth_areas.h"

namespace terrazzo {

// Cheaper than DepthSweep where there are far more vertices than depths: nothing is sorted, and areas need no
// coordinates but heights. By the divergence theorem in the plane a section's area is half the sum of its
// chords' lengths times their distances from the origin; a triangle of area T, unit normal n and vertices'
// heights z₀ ≤ z₁ ≤ z₂ thus adds T·(n·x − z·n_z)·hat(z)/(z₂ − z₀), hat rising from 0 at z₀ to 1 at z₁ and
// falling to 0 at z₂.
class GridSweep {
 public:
  explicit GridSweep(const Mesh& mesh);
  // Exact at the ends and the middle of every range, a quadratic in between; valid until the next call.
  // Ranges thin out as squares towards both tangent planes, where small profiles come from. Convex bodies
  // only: others would have several profiles added up.
  const std::vector<AreaRange>& sweep(const Vec3& direction);

 private:
  struct Facet {
    std::int32_t a, b, c;
    Vec3 area;      // T·n
    double offset;  // T·n·x
  };
  struct Place {
    double depth;    // share of the height above the lowest vertex
    double ordinal;  // of the range that it lies in, with the way through it
  };
  std::vector<Vec3> vertex_;
  std::vector<Facet> facets_;
  std::vector<Place> place_;
  std::vector<double> node_depth_, node_area_;  // ends and middles of the ranges, in turn
  std::vector<AreaRange> ranges_;
};

}  // namespace terrazzo

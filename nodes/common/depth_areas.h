// The section area of a mesh at all depths of one direction at once.
#pragma once

#include <vector>

#include "nodes/data/shapes.h"

namespace terrazzo {

// Between two neighbouring vertex heights the area is a quadratic of the depth: its values at both ends and
// halfway.
struct DepthAreas {
  std::vector<double> height;             // of the vertices along the direction, rising, mm
  std::vector<double> low, middle, high;  // one per interval between heights, mm²
  double max_area() const;                // over all depths, exact
};

// Sweeps a mesh along directions. Holds scratch memory: one per thread.
class DepthSweep {
 public:
  explicit DepthSweep(const Mesh& mesh);
  // Valid until the next call. Every triangle adds a quadratic to the intervals that it spans; sums of
  // differences over the sorted heights give all intervals in one pass.
  const DepthAreas& sweep(const Vec3& direction);

 private:
  void sort_heights();

  const Mesh& mesh_;
  double radius_;
  std::vector<Vec3> point_;  // vertices in coordinates whose z is the direction
  std::vector<std::int32_t> order_, rank_, bucket_;
  std::vector<double> c0_, c1_, c2_;  // differences of the coefficients
  DepthAreas areas_;
};

}  // namespace terrazzo

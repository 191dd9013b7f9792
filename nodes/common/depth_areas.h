// The section area of a mesh at all depths of one direction at once.
#pragma once

#include <vector>

#include "nodes/common/height_order.h"

namespace terrazzo {

// Over a range of depths the area is a quadratic of the depth.
struct AreaRange {
  double thickness;          // of the range, mm
  double low, middle, high;  // area at both ends and halfway, mm²
};

double max_area(const AreaRange&);  // within the range, exact

// Sweeps a mesh along directions. Holds scratch memory: one per thread.
class DepthSweep {
 public:
  explicit DepthSweep(const Mesh& mesh);
  // Total section area between each two neighbouring vertices, from the lowest up; valid until the next call.
  // Every triangle adds a quadratic to the ranges that it spans; sums of differences give all ranges in one
  // pass.
  const std::vector<AreaRange>& sweep(const Vec3& direction);

 private:
  const Mesh& mesh_;
  HeightOrder order_;
  double flat_;  // mm; triangles' parts no higher than that are added to their ranges one by one
  std::vector<Quadratic> difference_;
  std::vector<AreaRange> ranges_;
};

}  // namespace terrazzo

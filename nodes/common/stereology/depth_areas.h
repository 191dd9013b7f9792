// Section areas of a mesh at all depths along a direction.
#pragma once

#include <vector>

#include "nodes/common/geometry/grid/height_order.h"

namespace terrazzo {

// A range of depths in which the area is a quadratic function of the depth.
struct AreaRange {
  double thickness;          // of the range, mm
  double low, middle, high;  // area at both ends and in the middle, mm²
};

double max_area(const AreaRange&);  // maximum within the range, exact

// Sweeps a mesh along directions. Contains scratch memory: use one per thread.
class DepthSweep {
 public:
  explicit DepthSweep(const Mesh& mesh);
  // Section area between every two consecutive vertices, from the lowest up; valid until the next call. Each
  // triangle adds a quadratic to the ranges that it spans; prefix sums of differences accumulate all ranges
  // in one pass.
  const std::vector<AreaRange>& sweep(const Vec3& direction);

 private:
  const Mesh& mesh_;
  HeightOrder order_;
  double flat_;  // mm; triangle parts of at most this height are added to each range separately
  std::vector<Quadratic> difference_;
  std::vector<AreaRange> ranges_;
};

}  // namespace terrazzo

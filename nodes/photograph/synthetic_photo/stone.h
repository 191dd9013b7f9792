// Shapes of single stones, seen from above.
#pragma once

#include <array>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/random.h"

namespace terrazzo::synthetic_photo {

// How the stones of one picture look like each other.
struct StoneFamily {
  double angular = 0.3;     // share of polyhedra
  double bumps = 0.06;      // relative amplitude of the outline's harmonics
  double elongation = 1.6;  // largest ratio of the two axes in view
  double flat_low = 0.3, flat_high = 0.9;
  bool aligned = false;  // long axes lie along `turn`, as in layers that water laid down
  double turn = 0;
  explicit StoneFamily(Random&);
};

class Stone {
 public:
  // `radius`: of the circle with about the same area in view, canvas pixels.
  Stone(Random&, const StoneFamily&, double radius);
  double reach() const { return reach_; }    // no point is farther from the center
  double height() const { return height_; }  // half of the vertical extent
  // Height of the surface above the stone's middle plane at an offset from its center; NaN outside.
  double top(double dx, double dy) const;

 private:
  double radius_, height_, reach_, cosine_, sine_, axis_a_, axis_b_;
  double power_ = 2, dome_ = 2, roughness_ = 0, rough_scale_ = 6;
  std::array<double, 6> wave_{}, phase_{};
  std::vector<Vec3> normals_;  // of a polyhedron
  std::vector<double> distances_;
  std::uint64_t seed_ = 0;
};

}  // namespace terrazzo::synthetic_photo

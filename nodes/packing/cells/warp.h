// A periodic deformation of space that keeps volumes and folds nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::tessellation {

// Flow along a random divergence-free field: a sum of plane waves whose displacement is perpendicular to
// their direction, over octaves of wavelengths with amplitudes in proportion. It follows the field in steps
// so short that each one is invertible. So it maps bodies without common points to such bodies, and a face
// shared by two bodies stays shared.
class Warp {
 public:
  // `coarsest`: longest wavelength in mm (at most the shortest edge of the box is used); `displacement`: its
  // root mean square, mm.
  Warp(const Vec3& box, double coarsest, double displacement, std::uint64_t seed);
  Vec3 operator()(Vec3 point) const;

 private:
  struct Wave {
    Vec3 vector, amplitude;  // 1/mm, mm
    double phase;
  };
  std::vector<Wave> waves_;
  int steps_ = 1;
};

}  // namespace terrazzo::tessellation

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "nodes/data/linear.h"

namespace terrazzo::exporting {

// Bunge's Euler angles in radians of the rotation from the box to the particle's frame.
inline std::array<double, 3> euler_angles(const Quat& orientation) {
  const Mat3 r = orientation.normalized().toRotationMatrix();  // = Rz(φ1)·Rx(Φ)·Rz(φ2)
  const auto positive = [](double angle) { return angle < 0 ? angle + 2 * std::numbers::pi : angle; };
  const double cosine = std::clamp(r(2, 2), -1.0, 1.0);
  if (std::hypot(r(2, 0), r(2, 1)) < 1e-9)
    return {positive(std::atan2(r(1, 0), r(0, 0))), cosine > 0 ? 0 : std::numbers::pi, 0};
  return {positive(std::atan2(r(0, 2), -r(1, 2))), std::acos(cosine), positive(std::atan2(r(2, 0), r(2, 1)))};
}

}  // namespace terrazzo::exporting

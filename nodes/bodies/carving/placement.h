// Placement of the material in the object.
#pragma once

#include "nodes/data/linear.h"

namespace terrazzo::carving {

// Maps an object's points to the material: rotation, then shift. An oblique cut through a periodic material
// does not repeat.
struct Placement {
  Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();  // rotates an object's directions into the material's
  Vec3f shift = Vec3f::Zero();                         // in periods of each axis

  // `degrees` around x, then y, then z.
  static Placement of(const Vec3& degrees, const Vec3& shift);
};

}  // namespace terrazzo::carving

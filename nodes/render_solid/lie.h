// How the material lies in the object.
#pragma once

#include "nodes/common/linear.h"

namespace terrazzo {

// Where an object's points lie in the material: turned, then shifted. An oblique cut through a periodic
// material does not repeat.
struct Lie {
  Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();  // of an object's directions into the material's
  Vec3f shift = Vec3f::Zero();                         // in periods of each axis

  // `degrees` about x, then y, then z.
  static Lie of(const Vec3& degrees, const Vec3& shift);
};

}  // namespace terrazzo

// Second moments of the area that a loop encloses.
#pragma once

#include "nodes/common/geometry/mesh/loop.h"

namespace terrazzo {

struct LoopMoments {
  double area = 0, longer = 0, shorter = 0;  // variances of the area along its principal axes
  Vec2 center = Vec2::Zero();
  double angle = 0;  // of the longer axis, radians counterclockwise from x, −π/2 to π/2
};

// Of a counterclockwise loop with a point; only `area` is set if that is not above 0.
LoopMoments loop_moments(const Loop&);

}  // namespace terrazzo

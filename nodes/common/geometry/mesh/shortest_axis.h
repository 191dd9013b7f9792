// How a body lies on the ground: with its shortest axis upright.
#pragma once

#include <optional>

#include "nodes/data/linear.h"
#include "nodes/data/shapes.h"

namespace terrazzo {

// Standard deviation of the tilt of loose stones about their flat position, radians, along each of two axes.
inline constexpr double kTilt = 0.3;

// The rotation that turns the shortest principal axis of the body's surface to z; none if no axis is the
// shortest, as of a ball or a cube.
std::optional<Quat> shortest_axis_up(const Mesh&);

}  // namespace terrazzo

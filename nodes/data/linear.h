// Vectors, matrices and rotations, as aliases of Eigen's types. Lengths in mm, right-handed.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace terrazzo {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;
using Vec3i = Eigen::Vector3i;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;  // memory order x, y, z, w; constructor order w, x, y, z

}  // namespace terrazzo

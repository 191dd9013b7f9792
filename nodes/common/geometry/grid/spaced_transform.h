// The transform of a scan, whose voxels may differ in length along the axes.
#pragma once

#include <openvdb/math/Transform.h>

#include <cmath>
#include <memory>

#include "nodes/data/linear.h"
#include "nodes/data/volume.h"

namespace terrazzo {

// Transform with the center of voxel (i, j, k) at (i + ½, j + ½, k + ½) · spacing, mm.
inline openvdb::math::Transform::Ptr voxel_transform(const Vec3& spacing) {
  voxel_transform(std::cbrt(spacing.prod()));  // refuses voxels that are too small for OpenVDB
  const openvdb::Vec3d step(spacing.x(), spacing.y(), spacing.z());
  openvdb::math::MapBase::Ptr map;
  if (step[0] == step[1] && step[0] == step[2])
    map = std::make_shared<openvdb::math::UniformScaleTranslateMap>(step[0], 0.5 * step);
  else
    map = std::make_shared<openvdb::math::ScaleTranslateMap>(step, 0.5 * step);
  return std::make_shared<openvdb::math::Transform>(map);
}

}  // namespace terrazzo

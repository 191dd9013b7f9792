// The transform of a scan, whose voxels may differ in length along the axes.
#pragma once

#include <fmt/format.h>
#include <openvdb/math/Transform.h>

#include <memory>

#include "graph/diagnostic.h"
#include "nodes/data/linear.h"

namespace terrazzo {

// Transform with the center of voxel (i, j, k) at (i + ½, j + ½, k + ½) · spacing, mm.
inline openvdb::math::Transform::Ptr voxel_transform(const Vec3& spacing) {
  constexpr double kSmallest = 3.1e-15;  // OpenVDB takes smaller voxels for empty ones
  if (!(spacing.prod() >= kSmallest))
    throw Error("bad-spacing",
                fmt::format("voxels of {} × {} × {} mm are too small: the product of their edges must be at "
                            "least {} mm³",
                            spacing.x(), spacing.y(), spacing.z(), kSmallest),
                "state all lengths in a larger unit, as if 1 µm were 1 mm");
  const openvdb::Vec3d step(spacing.x(), spacing.y(), spacing.z());
  openvdb::math::MapBase::Ptr map;
  if (step[0] == step[1] && step[0] == step[2])
    map = std::make_shared<openvdb::math::UniformScaleTranslateMap>(step[0], 0.5 * step);
  else
    map = std::make_shared<openvdb::math::ScaleTranslateMap>(step, 0.5 * step);
  return std::make_shared<openvdb::math::Transform>(map);
}

}  // namespace terrazzo

#include "nodes/common/geometry/coverage.h"

#include <algorithm>
#include <cmath>

#include "nodes/common/geometry/grid/convert_grid.h"

namespace terrazzo {

double coverage_of(double distance, double voxel) { return std::clamp(0.5 - distance / voxel, 0.0, 1.0); }

std::shared_ptr<openvdb::FloatGrid> coverage_of(const openvdb::FloatGrid& level_set) {
  const openvdb::Vec3d edges = level_set.voxelSize();
  const double voxel = std::cbrt(edges.x() * edges.y() * edges.z());
  const auto fog = convert_grid<openvdb::FloatGrid>(
      level_set, [&](float distance) { return static_cast<float>(coverage_of(double{distance}, voxel)); });
  for (auto it = fog->beginValueAll(); it; ++it) it.setActiveState(*it > 0);
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  return fog;
}

}  // namespace terrazzo

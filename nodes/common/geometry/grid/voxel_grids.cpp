#include "nodes/common/geometry/grid/voxel_grids.h"

#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/geometry/grid/spaced_transform.h"
#include "nodes/data/volume.h"

namespace terrazzo {

void add_number_grid(Volume& volume, const std::string& name, const Vec3i& size, const Vec3& spacing,
                     const Work& work, const std::function<float(std::size_t)>& value, const Vec3i& first) {
  initialize_openvdb();
  auto grid = dense_grid<openvdb::FloatGrid>(name.c_str(), size, 1, work, value, first);
  grid->setTransform(voxel_transform(spacing));
  volume.grids.push_back(grid);
}

void add_vector_grid(Volume& volume, const std::string& name, const Vec3i& size, double voxel,
                     const Work& work, const std::function<Vec3f(std::size_t)>& value) {
  initialize_openvdb();
  volume.grids.push_back(dense_grid<openvdb::Vec3SGrid>(name.c_str(), size, voxel, work, [&](std::size_t i) {
    const Vec3f v = value(i);
    return openvdb::Vec3s(v.x(), v.y(), v.z());
  }));
}

void add_id_grid(Volume& volume, const std::string& name, const Vec3i& size, const Vec3& spacing,
                 const Work& work, const std::function<std::int32_t(std::size_t)>& value) {
  initialize_openvdb();
  auto grid = dense_grid<openvdb::Int32Grid>(name.c_str(), size, 1, work, value);
  mark_binder(*grid);
  grid->setTransform(voxel_transform(spacing));
  volume.grids.push_back(grid);
}

void add_phase_grid(Volume& volume, const Vec3i& size, const Vec3& spacing, const Work& work,
                    const std::function<std::int32_t(std::size_t)>& value) {
  initialize_openvdb();
  auto grid = dense_grid<openvdb::Int32Grid>("phase", size, 1, work, value);
  grid->setTransform(voxel_transform(spacing));
  volume.grids.push_back(grid);
}

}  // namespace terrazzo

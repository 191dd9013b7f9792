#include "nodes/media/annealing/phase_grid.h"

#include "nodes/common/geometry/grid/dense_grid.h"

namespace terrazzo::annealing {

void check_voxel(double voxel) { voxel_transform(voxel); }

Volume phase_volume(const std::vector<std::uint8_t>& phase, const Vec3i& size, double voxel,
                    const std::vector<Vec3f>& color, const std::optional<Vec3i>& block, const Work& work) {
  initialize_openvdb();
  Volume out;
  if (block) {
    out.first = *block;
    out.extent = size;
  } else {
    out.resolution = size;
  }
  const Vec3i origin = block.value_or(Vec3i::Zero());
  out.grids.push_back(dense_grid<openvdb::Int32Grid>(
      "phase", size, voxel, work.part(0, 0.5), [&](std::size_t i) { return std::int32_t{phase[i]}; },
      origin));
  out.grids.push_back(dense_grid<openvdb::Vec3SGrid>(
      "Cd", size, voxel, work.part(0.5, 1),
      [&](std::size_t i) {
        const Vec3f& c = color[phase[i]];
        return openvdb::Vec3s(c.x(), c.y(), c.z());
      },
      origin));
  return out;
}

}  // namespace terrazzo::annealing

#include "nodes/volumes/voxelize/binder_detail.h"

#include "nodes/data/indices.h"

namespace terrazzo::voxelize {

BinderDetail::BinderDetail(const residual::ResidualField& field, const Slab& slab, double voxel,
                           const Work& work)
    : planes(static_cast<std::size_t>(slab.z1 - slab.z0)) {
  const std::size_t plane = pixels_in(slab.lattice.x(), slab.lattice.y());
  work.parallel(planes.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k)
      for (std::size_t at = 0; at < plane; ++at) {
        const std::size_t i = k * plane + at;
        if (cover_of(slab, i) >= 1) continue;
        planes[k].push_back(field.behind(center_of(slab, at, slab.z0 + static_cast<int>(k), voxel),
                                         slab.id[i], std::abs(slab.distance[i]) * static_cast<float>(voxel)));
      }
  });
}

std::size_t BinderDetail::bytes() const {
  std::size_t out = sizeof(*this);
  for (const auto& p : planes) out += sizeof(p) + p.capacity() * sizeof(Vec3f);
  return out;
}

}  // namespace terrazzo::voxelize

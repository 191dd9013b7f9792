#include "nodes/detail/detail_solid/apply.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/detail.h"
#include "nodes/data/particles.h"
#include "nodes/data/volume.h"
#include "nodes/detail/residual/residual_field.h"

namespace terrazzo::detail_solid {
namespace {

// What the voxels say of the particles: the place and the color of each.
struct Seen {
  Vec3 sine = Vec3::Zero(), cosine = Vec3::Zero();  // of the voxels' angles around the box
  Vec3 color = Vec3::Zero();
  double weight = 0;
};

Particles particles_of(const openvdb::Int32Grid& id, const openvdb::Vec3SGrid& color,
                       const openvdb::FloatGrid* density, const Vec3i& size, double voxel, const Work& work) {
  int last = -1;
  for (auto it = id.cbeginValueOn(); it; ++it) last = std::max(last, *it);
  if (last > 10'000'000)
    throw Error("no-id", fmt::format("the grid id has the index {}, which is too large", last));
  std::vector<Seen> seen(last + 1);
  auto ids = id.getConstAccessor();
  auto colors = color.getConstAccessor();
  const Vec3 turn = 2 * std::numbers::pi * size.cast<double>().cwiseInverse();
  for (int k = 0; k < size.z(); ++k) {
    work.check();
    for (int j = 0; j < size.y(); ++j)
      for (int i = 0; i < size.x(); ++i) {
        const openvdb::Coord at(i, j, k);
        const int p = ids.getValue(at);
        if (p < 0) continue;
        Seen& s = seen[p];
        for (int a = 0; a < 3; ++a) {
          const double angle = (at[a] + 0.5) * turn[a];
          s.sine[a] += std::sin(angle);
          s.cosine[a] += std::cos(angle);
        }
        const double cover = density ? density->tree().getValue(at) : 1;
        const double w = cover >= 0.999 ? 1 : 1e-6;
        const auto& c = colors.getValue(at);
        s.color += w * Vec3(c[0], c[1], c[2]);
        s.weight += w;
      }
  }
  Particles out;
  out.box = size.cast<double>() * voxel;
  out.resize(seen.size());
  for (std::size_t p = 0; p < seen.size(); ++p) {
    if (!(seen[p].weight > 0)) continue;
    for (int a = 0; a < 3; ++a) {
      double angle = std::atan2(seen[p].sine[a], seen[p].cosine[a]);
      if (angle < 0) angle += 2 * std::numbers::pi;
      out.position[p][a] = angle / turn[a] * voxel;
    }
    out.color[p] = (seen[p].color / seen[p].weight).cast<float>();
  }
  return out;
}

}  // namespace

Volume add_detail(const Volume& volume, const Detail& detail, const Work& work) {
  const auto color = volume.find<openvdb::Vec3SGrid>("Cd");
  if (!color) throw Error("no-color", "the volume has no Vec3SGrid named Cd", "connect Voxelize.volume");
  const auto id = volume.find<openvdb::Int32Grid>("id");
  if (!id) throw Error("no-id", "the volume has no Int32Grid named id", "connect Voxelize.volume");
  const auto density = volume.find<openvdb::FloatGrid>("density");
  const Vec3i size = volume.resolution;
  if (size.minCoeff() < 1)
    throw Error("not-periodic", "the volume is not periodic", "connect Voxelize.volume");
  const double voxel = color->transform().voxelSize()[0];
  const Particles particles = particles_of(*id, *color, density.get(), size, voxel, work);
  const residual::ResidualField field(detail, particles, voxel, residual::Keep::Values, work.part(0, 0.1));
  const std::size_t nx = size.x(), plane = nx * size.y();
  std::vector<Vec3f> out(plane * size.z());
  work.part(0.1, 0.9).parallel(size.z(), 1, [&](std::size_t begin, std::size_t end) {
    auto ids = id->getConstAccessor();
    auto colors = color->getConstAccessor();
    for (std::size_t k = begin; k < end; ++k)
      for (std::size_t n = 0; n < plane; ++n) {
        const openvdb::Coord at(static_cast<int>(n % nx), static_cast<int>(n / nx), static_cast<int>(k));
        const int p = ids.getValue(at);
        const Vec3f mm = ((Vec3(at[0], at[1], at[2]).array() + 0.5) * voxel).matrix().cast<float>();
        const float cover = density ? std::clamp(density->tree().getValue(at), 0.0f, 1.0f) : 1;
        const Vec3f offset = field.mixed(mm, p, cover);
        const auto& c = colors.getValue(at);
        out[k * plane + n] =
            srgb_to_linear((linear_to_srgb(Vec3f(c[0], c[1], c[2])) + offset).cwiseMax(0.0f));
      }
  });
  Volume result;
  result.resolution = size;
  for (const auto& g : volume.grids)
    result.grids.push_back(
        g->getName() != "Cd"
            ? g
            : dense_grid<openvdb::Vec3SGrid>("Cd", size, voxel, work.part(0.9, 1), [&](std::size_t i) {
                return openvdb::Vec3s(out[i].x(), out[i].y(), out[i].z());
              }));
  return result;
}

}  // namespace terrazzo::detail_solid

#include "nodes/bodies/carving/hidden_phases.h"

#include <fmt/format.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/geometry/grid/floor_of.h"
#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/common/geometry/periodic.h"

namespace terrazzo::carving {
namespace {

constexpr int kPadding = 2;      // voxels around the period, whose surface its own continues
constexpr double kSlack = 1e-3;  // voxels

// The voxel's number in its period, or that of the nearest voxel if the volume does not repeat.
int nearest_in(int i, int n, bool periodic) { return periodic ? wrap_index(i, n) : std::clamp(i, 0, n - 1); }

std::vector<float> smoothed(const HiddenVoxels& h, const Work& work) {
  std::vector<float> out(h.in.begin(), h.in.end()), before;
  const Vec3i n = h.size;
  for (int axis = 0; axis < 3; ++axis) {
    before = out;
    work.quiet().parallel(n.z(), 4, [&](std::size_t begin, std::size_t end) {
      for (int z = static_cast<int>(begin); z < static_cast<int>(end); ++z)
        for (int y = 0; y < n.y(); ++y)
          for (int x = 0; x < n.x(); ++x) {
            Vec3i low(x, y, z), high = low;
            low[axis] = nearest_in(low[axis] - 1, n[axis], h.periodic);
            high[axis] = nearest_in(high[axis] + 1, n[axis], h.periodic);
            out[voxel_at(x, y, z, n)] = 0.5f * before[voxel_at(x, y, z, n)] +
                                        0.25f * (before[voxel_at(low.x(), low.y(), low.z(), n)] +
                                                 before[voxel_at(high.x(), high.y(), high.z(), n)]);
          }
    });
  }
  return out;
}

struct Surface {
  std::vector<openvdb::Vec3s> points;  // voxel (0, 0, 0) is centered at the origin
  std::vector<openvdb::Vec4I> quads;
};

// Of the period and the padding around it.
Surface surface_of(const HiddenVoxels& h, const std::vector<float>& values, const Work& work) {
  initialize_openvdb();
  const Vec3i padded = h.size + Vec3i::Constant(2 * kPadding);
  const auto grid = dense_grid<openvdb::FloatGrid>(
      "hidden", padded, 1, work.quiet(),
      [&](std::size_t i) {
        const auto along = [&](std::size_t at, int axis) {
          return nearest_in(static_cast<int>(at) - kPadding, h.size[axis], h.periodic);
        };
        const std::size_t row = i / padded.x();
        return values[voxel_at(along(i % padded.x(), 0), along(row % padded.y(), 1),
                               along(row / padded.y(), 2), h.size)];
      },
      Vec3i::Constant(-kPadding));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(1));
  Surface out;
  std::vector<openvdb::Vec3I> triangles;  // none without adaptivity
  // On one thread, so that the order is always the same.
  tbb::task_arena arena(1);
  arena.execute(
      [&] { openvdb::tools::volumeToMesh(*grid, out.points, triangles, out.quads, 0.5, 0.0, true); });
  return out;
}

// Whether a quad belongs to the period: its center, or any corner if the surface is cut off where it ends.
bool belongs(const Surface& s, const openvdb::Vec4I& q, const HiddenVoxels& h) {
  const auto within = [&](const Vec3& p) {
    return (p.array() >= -0.5 - kSlack).all() &&
           (p.array() <= h.size.cast<double>().array() - 0.5 + kSlack).all();
  };
  Vec3 center = Vec3::Zero();
  bool any = false;
  for (int k = 0; k < 4; ++k) {
    const auto& p = s.points[q[k]];
    const Vec3 corner(p.x(), p.y(), p.z());
    center += corner / 4;
    any = any || within(corner);
  }
  return h.periodic ? within(center) : any;
}

// The surface in the period, in voxels from its middle.
Mesh mesh_of(const Surface& s, const HiddenVoxels& h) {
  const Vec3 size = h.size.cast<double>(), slack = Vec3::Constant(kSlack);
  Mesh out;
  std::vector<std::int32_t> number(s.points.size(), -1);
  const auto vertex = [&](openvdb::Index32 i) {
    if (number[i] < 0) {
      number[i] = count_of(out.vertices);
      Vec3 p = Vec3(s.points[i].x(), s.points[i].y(), s.points[i].z()) + Vec3::Constant(0.5);
      if (!h.periodic) p = p.cwiseMax(-slack).cwiseMin(size + slack);
      out.vertices.push_back(p - size / 2);
    }
    return number[i];
  };
  for (const auto& q : s.quads) {
    if (!belongs(s, q, h)) continue;
    const std::array<std::int32_t, 4> v{vertex(q[0]), vertex(q[1]), vertex(q[2]), vertex(q[3])};
    // The library's order is clockwise seen from where values are larger, which is inside.
    out.triangles.push_back({v[2], v[1], v[0]});
    out.triangles.push_back({v[3], v[2], v[0]});
  }
  return out;
}

}  // namespace

HiddenVoxels hidden_voxels(const Volume& volume, std::vector<std::int64_t> phases, const Work& work) {
  std::sort(phases.begin(), phases.end());
  phases.erase(std::unique(phases.begin(), phases.end()), phases.end());
  const auto names = grid_names(volume);
  if (std::count(names.begin(), names.end(), "phase") == 0)
    throw Error("no-such-grid", "the volume has no grid 'phase'",
                "connect a volume of phases, for example from MediaSolid");
  const VoxelBox box = voxel_box(volume);
  const VoxelSource source(volume, "phase", box);
  if (!source.whole() || source.components() != 1)
    throw Error("no-such-grid", "the grid 'phase' does not hold whole numbers",
                "connect a volume of phases, for example from MediaSolid");
  HiddenVoxels out{box.size, box.periodic, {}};
  out.in.resize(box.count());
  std::vector<std::size_t> found(phases.size(), 0);
  std::vector<std::int32_t> plane(box.plane());
  std::size_t hidden = 0;
  for (int z = 0; z < box.size.z(); ++z) {
    work.check();
    source.read(z, z + 1, plane.data());
    for (std::size_t i = 0; i < plane.size(); ++i)
      if (const auto at = std::find(phases.begin(), phases.end(), plane[i]); at != phases.end()) {
        out.in[box.plane() * z + i] = 1;
        ++found[at - phases.begin()];
        ++hidden;
      }
  }
  for (std::size_t k = 0; k < phases.size(); ++k)
    if (found[k] == 0)
      throw Error("no-such-phase", fmt::format("the volume has no phase {}", phases[k]),
                  "hide a phase of the grid 'phase'");
  if (hidden == out.in.size()) throw Error("all-hidden", "all phases are hidden", "leave one visible");
  return out;
}

bool HiddenVoid::holds(const Vec3f& point) const {
  const Vec3f p = point / static_cast<float>(voxel) - Vec3f::Constant(0.5f);
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    float weight = 1;
    Vec3i at;
    for (int a = 0; a < 3; ++a) {
      const int low = floor_of(p[a]), high = corner >> a & 1;
      const float t = p[a] - static_cast<float>(low);
      weight *= high ? t : 1 - t;
      at[a] = nearest_in(low + high, size[a], periodic);
    }
    sum += weight * share[voxel_at(at.x(), at.y(), at.z(), size)];
  }
  return sum > 0.5f;
}

double hidden_forecast(const HiddenVoxels& h, const Work& work) {
  // Faces between hidden voxels and others, each of which becomes about two triangles.
  const double faces = work.quiet().reduce(
      h.size.z(), 4, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double n = 0;
        for (int z = static_cast<int>(begin); z < static_cast<int>(end); ++z)
          for (int y = 0; y < h.size.y(); ++y)
            for (int x = 0; x < h.size.x(); ++x) {
              const auto differs = [&](int u, int v, int w) {
                return h.in[voxel_at(
                           nearest_in(u, h.size.x(), h.periodic), nearest_in(v, h.size.y(), h.periodic),
                           nearest_in(w, h.size.z(), h.periodic), h.size)] != h.in[voxel_at(x, y, z, h.size)];
              };
              n += differs(x + 1, y, z) + differs(x, y + 1, z) + differs(x, y, z + 1);
            }
        return n;
      },
      [](double a, double b) { return a + b; });
  return 14.0 * voxels_in(h.size) + 700 * faces;
}

HiddenVoid hidden_void(const HiddenVoxels& h, double voxel, const Work& work) {
  HiddenVoid out{{}, {}, voxel, h.periodic, h.size, smoothed(h, work)};
  Shape shape;
  shape.name = "hidden";
  shape.smooth = true;
  shape.mesh = mesh_of(surface_of(h, out.share, work), h);
  if (shape.mesh.triangles.empty())
    throw Error("no-surface",
                "the hidden phases, or the visible ones, are thinner than two voxels everywhere",
                "hide other phases, or use a finer volume");
  for (Vec3& v : shape.mesh.vertices) v *= voxel;
  out.shapes.shapes.push_back(std::move(shape));
  out.particles.box = voxel * h.size.cast<double>();
  out.particles.resize(1);
  out.particles.position[0] = out.particles.box / 2;
  out.particles.voids = {1};
  return out;
}

}  // namespace terrazzo::carving

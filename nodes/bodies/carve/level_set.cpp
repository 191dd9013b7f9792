#include "nodes/bodies/carve/level_set.h"

#include <openvdb/tools/Composite.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/task_arena.h>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/disjoint_sets.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/volume.h"

namespace terrazzo::carve {
namespace {

constexpr float kBand = 3;  // voxels

// On one thread, so that equal distances are always decided in the same way.
template <class Call>
void alone(Call&& call) {
  tbb::task_arena arena(1);
  arena.execute(call);
}

// Null if there are no triangles.
openvdb::FloatGrid::Ptr grid_of(const Mesh& mesh, const std::vector<Triangle>& triangles, double mm,
                                double voxel) {
  if (triangles.empty()) return nullptr;
  std::vector<openvdb::Vec3s> points;
  for (const Vec3& v : mesh.vertices) {
    const Vec3f p = (v * (mm / voxel) - Vec3::Constant(0.5)).cast<float>();
    points.emplace_back(p.x(), p.y(), p.z());
  }
  std::vector<openvdb::Vec3I> corners;
  for (const Triangle& t : triangles)
    corners.emplace_back(static_cast<openvdb::Index32>(t[0]), static_cast<openvdb::Index32>(t[1]),
                         static_cast<openvdb::Index32>(t[2]));
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(points, corners);
  openvdb::util::NullInterrupter never;
  return openvdb::tools::meshToVolume<openvdb::FloatGrid>(never, adapter, *voxel_transform(voxel), kBand,
                                                          kBand, 0, nullptr);
}

// The library fills cavities, so surfaces that face inward are subtracted.
openvdb::FloatGrid::Ptr grid_of(const Mesh& mesh, double mm, double voxel) {
  DisjointSets sets(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[0], t[2]);
  }
  std::vector<double> volume(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles)
    volume[sets.find(t[0])] += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  std::vector<Triangle> outer, inner;
  for (const Triangle& t : mesh.triangles) (volume[sets.find(t[0])] < 0 ? inner : outer).push_back(t);
  auto grid = grid_of(mesh, outer, mm, voxel);
  const auto cavities = grid_of(mesh, inner, mm, voxel);
  if (grid && cavities) openvdb::tools::csgDifference(*grid, *cavities);
  return grid;
}

Mesh box_mesh(const Eigen::AlignedBox3d& box) {
  Mesh m;
  for (int i = 0; i < 8; ++i)
    m.vertices.push_back(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

Volume named(openvdb::FloatGrid::Ptr grid) {
  if (!grid) throw Error("empty-body", "the body has no surface");
  grid->setName("surface");
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  Volume out;
  out.grids.push_back(std::move(grid));
  return out;
}

}  // namespace

Volume level_set(const Mesh& mesh, double voxel, const Work& work) {
  initialize_openvdb();
  work.check();
  openvdb::FloatGrid::Ptr grid;
  alone([&] { grid = grid_of(mesh, 1, voxel); });
  return named(std::move(grid));
}

Volume level_set(const carving::BodyParts& parts, double mm, double voxel, const Work& work) {
  initialize_openvdb();
  openvdb::FloatGrid::Ptr grid;
  const auto step = [&](const auto& call) {
    work.check();
    alone(call);
  };
  step([&] { grid = grid_of(parts.base.mesh, mm, voxel); });
  step([&] {
    if (const auto removed = grid_of(parts.removed, parts.removed.triangles, mm, voxel))
      openvdb::tools::csgDifference(*grid, *removed);
  });
  step([&] {
    if (const auto kept = grid_of(parts.kept, parts.kept.triangles, mm, voxel))
      openvdb::tools::csgUnion(*grid, *kept);
  });
  step([&] {
    if (!parts.box.isEmpty())
      openvdb::tools::csgIntersection(*grid, *grid_of(box_mesh(parts.box), mm, voxel));
  });
  return named(std::move(grid));
}

Mesh surface_of(const Volume& volume) {
  const auto grid = volume.find<openvdb::FloatGrid>("surface");
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  alone([&] { openvdb::tools::volumeToMesh(*grid, points, triangles, quads, 0.0, 0.0, true); });
  Mesh mesh;
  for (const auto& p : points) mesh.vertices.push_back(Vec3(p.x(), p.y(), p.z()));
  const auto add = [&](openvdb::Index32 a, openvdb::Index32 b, openvdb::Index32 c) {
    // The library's order is clockwise seen from outside.
    mesh.triangles.push_back(
        {static_cast<std::int32_t>(c), static_cast<std::int32_t>(b), static_cast<std::int32_t>(a)});
  };
  for (const auto& t : triangles) add(t[0], t[1], t[2]);
  for (const auto& q : quads) {
    if ((points[q[0]] - points[q[2]]).lengthSqr() <= (points[q[1]] - points[q[3]]).lengthSqr()) {
      add(q[0], q[1], q[2]);
      add(q[0], q[2], q[3]);
    } else {
      add(q[1], q[2], q[3]);
      add(q[1], q[3], q[0]);
    }
  }
  if (mesh.triangles.empty())
    throw Error("empty-body", "nothing is left of the body at this edge length", "reduce edge");
  return mesh;
}

void add_colors(Volume& volume, const std::function<Vec3f(const Vec3& p, const Vec3& n)>& color,
                const Work& work) {
  const auto surface = volume.find<openvdb::FloatGrid>("surface");
  auto colors = openvdb::Vec3SGrid::create();
  colors->setName("Cd");
  colors->setTransform(surface->transform().copy());
  std::vector<const openvdb::FloatTree::LeafNodeType*> leaves;
  for (auto leaf = surface->tree().cbeginLeaf(); leaf; ++leaf) leaves.push_back(&*leaf);
  std::vector<openvdb::Vec3STree::LeafNodeType*> made(leaves.size(), nullptr);
  work.parallel(leaves.size(), 16, [&](std::size_t begin, std::size_t end) {
    auto voxels = surface->getConstAccessor();
    for (std::size_t n = begin; n < end; ++n) {
      auto leaf =
          std::make_unique<openvdb::Vec3STree::LeafNodeType>(leaves[n]->origin(), openvdb::Vec3s(0.0f));
      for (auto at = leaves[n]->cbeginValueOn(); at; ++at) {
        const openvdb::Coord c = at.getCoord();
        Vec3 slope;
        for (int k = 0; k < 3; ++k) {
          openvdb::Coord low = c;
          openvdb::Coord high = c;
          --low[k];
          ++high[k];
          slope[k] = double(voxels.getValue(high)) - double(voxels.getValue(low));
        }
        const Vec3 normal = slope.norm() > 0 ? Vec3(slope.normalized()) : Vec3(Vec3::UnitZ());
        const openvdb::Vec3d w = surface->transform().indexToWorld(c);
        const Vec3f v = color(Vec3(w.x(), w.y(), w.z()) - double(*at) * normal, normal);
        leaf->setValueOn(at.pos(), openvdb::Vec3s(v.x(), v.y(), v.z()));
      }
      made[n] = leaf.release();
    }
  });
  for (auto* leaf : made) colors->tree().addLeaf(leaf);
  volume.grids.push_back(std::move(colors));
}

void move(Volume& volume, const Vec3& offset) {
  for (auto& grid : volume.grids) {
    const auto transform = grid->transform().copy();
    transform->postTranslate(openvdb::Vec3d(offset.x(), offset.y(), offset.z()));
    grid = grid->copyGridReplacingTransform(transform);
  }
}

}  // namespace terrazzo::carve

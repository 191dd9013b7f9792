#include "nodes/export/tiled_packing.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/export/cut_mesh.h"
#include "nodes/export/instances.h"
#include "runtime/memory.h"

namespace terrazzo::exporting {
namespace {

Mesh placed_mesh(const Particles& particles, const Shapes& shapes, std::size_t i) {
  Mesh mesh = shapes.shapes[particles.shape[i]].mesh;
  transform(mesh, particles.orientation[i].normalized().toRotationMatrix() * particles.scale[i],
            particles.position[i]);
  return mesh;
}

bool within(const Mesh& mesh, const Vec3& box) {
  for (const Vec3& v : mesh.vertices)
    if ((v.array() < 0).any() || (v.array() > box.array()).any()) return false;
  return true;
}

void append(TiledPacking& to, const Particles& from, std::size_t i) {
  to.index.push_back(static_cast<std::int32_t>(i));
  to.particles.shape.push_back(from.shape[i]);
  to.particles.cls.push_back(from.cls[i]);
  to.particles.position.push_back(from.position[i]);
  to.particles.orientation.push_back(from.orientation[i]);
  to.particles.scale.push_back(from.scale[i]);
  to.particles.size.push_back(from.size[i]);
  to.particles.color.push_back(from.color[i]);
}

// Moves by whole edges of the box that bring a part of the mesh into it, but for none at all.
std::vector<Vec3> moves_into_box(const Mesh& mesh, const Vec3& box) {
  Eigen::AlignedBox3d reach;
  for (const Vec3& v : mesh.vertices) reach.extend(v);
  const Vec3 first = (-reach.max().cwiseQuotient(box)).array().ceil();
  std::vector<Vec3> moves;
  for (double z = first.z(); reach.min().z() + z * box.z() < box.z(); ++z)
    for (double y = first.y(); reach.min().y() + y * box.y() < box.y(); ++y)
      for (double x = first.x(); reach.min().x() + x * box.x() < box.x(); ++x) {
        const Vec3 move = Vec3(x, y, z).cwiseProduct(box);
        if (move.isZero(0)) continue;
        Mesh part = mesh;
        for (Vec3& v : part.vertices) v += move;
        for (int axis = 0; axis < 3 && !part.triangles.empty(); ++axis)
          part = cut_mesh(cut_mesh(part, axis, 0, false), axis, box[axis], true);
        if (!part.triangles.empty()) moves.push_back(move);
      }
  return moves;
}

// What a particle becomes: moves of its images, or parts.
struct Tiling {
  bool whole = true;
  std::vector<Vec3> moves;
  std::vector<Mesh> parts;
  double volume = 0;  // in the box
};

Tiling tiling_of(const Particles& particles, const Shapes& shapes, std::size_t i, Crossing crossing,
                 bool flat_caps) {
  Tiling out;
  if (particles.is_void(i)) return out;
  const Mesh mesh = placed_mesh(particles, shapes, i);
  out.whole = within(mesh, particles.box);
  if (out.whole) {
    out.volume = mesh_volume(mesh);
  } else if (crossing == Crossing::Repeated) {
    out.moves = moves_into_box(mesh, particles.box);
  } else {
    out.parts = parts_in_box(mesh, particles.box);
    for (Mesh& part : out.parts) {
      out.volume += mesh_volume(part);
      if (flat_caps && shapes.shapes[particles.shape[i]].smooth) part = with_flat_caps(part, particles.box);
    }
  }
  return out;
}

// Before anything is cut.
void check_sizes(const Particles& particles, const Shapes& shapes, Crossing crossing, std::uint64_t memory) {
  constexpr double kMostBoxes = 16, kFarthest = 1e6, kPerTriangle = 80;  // bytes of a part and its copy
  std::vector<double> radius;
  for (const Shape& s : shapes.shapes) {
    if (!std::all_of(s.mesh.vertices.begin(), s.mesh.vertices.end(),
                     [](const Vec3& v) { return v.allFinite(); }))
      throw Error("bad-number", "the shape '" + s.name + "' has a vertex that is not finite");
    radius.push_back(mesh_bounding_radius(s.mesh));
  }
  double triangles = 0;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (particles.is_void(i)) continue;
    if (!(particles.position[i].cwiseQuotient(particles.box).cwiseAbs().maxCoeff() < kFarthest))
      throw Error("bad-number",
                  fmt::format("particle {} is more than {:g} boxes away from the box", i, kFarthest),
                  "move it into the periodic box, or set crossing to once")
          .parameter("crossing");
    const double reach = radius[particles.shape[i]] * std::abs(particles.scale[i]);
    if (2 * reach > kMostBoxes * particles.box.minCoeff())
      throw Error(
          "box-too-small",
          fmt::format("particle {} is {:.4g} mm wide, more than {:g} times the box's edge of {:.4g} mm", i,
                      2 * reach, kMostBoxes, particles.box.minCoeff()),
          "make a larger box, or set crossing to once")
          .parameter("crossing");
    const Vec3& p = particles.position[i];
    if ((p.array() < reach).any() || (p.array() > particles.box.array() - reach).any())
      triangles += static_cast<double>(shapes.shapes[particles.shape[i]].mesh.triangles.size());
  }
  if (crossing == Crossing::Cut)
    require_memory(kPerTriangle * triangles, memory, "the parts of the particles that are cut");
}

void append_part(TiledPacking& to, const Particles& from, const Shapes& shapes, std::size_t i, Mesh mesh,
                 std::size_t number) {
  append(to, from, i);
  Shape shape;
  const Shape& whole = shapes.shapes[from.shape[i]];
  shape.name = fmt::format("{}_{}_part_{}", whole.name, i, number);
  shape.probability = 0;
  shape.smooth = whole.smooth;
  shape.mesh = std::move(mesh);
  shape.volume = mesh_volume(shape.mesh);
  to.particles.shape.back() = count_of(to.shapes.shapes);
  to.particles.position.back().setZero();
  to.particles.orientation.back().setIdentity();
  to.particles.scale.back() = 1;
  to.shapes.shapes.push_back(std::move(shape));
  ++to.parts;
}

}  // namespace

TiledPacking tiled_packing(const Particles& particles, const Shapes& shapes, Crossing crossing,
                           bool flat_caps, std::uint64_t memory, const Work& work) {
  instances_of(particles, shapes);  // checks them
  if (crossing == Crossing::Once) return {particles, shapes};
  if (!(particles.box.allFinite() && (particles.box.array() > 0).all()))
    throw Error("bad-box", fmt::format("the box has the edges {}, {} and {} mm", particles.box.x(),
                                       particles.box.y(), particles.box.z()));
  check_sizes(particles, shapes, crossing, memory);
  std::vector<Tiling> tilings(particles.count());
  work.parallel(particles.count(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      tilings[i] = tiling_of(particles, shapes, i, crossing, flat_caps);
  });
  TiledPacking out;
  out.particles.box = particles.box;
  out.particles.binder_color = particles.binder_color;
  out.shapes = shapes;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (particles.is_void(i)) continue;
    Tiling& tiling = tilings[i];
    for (std::size_t p = 0; p < tiling.parts.size(); ++p)
      append_part(out, particles, shapes, i, std::move(tiling.parts[p]), p);
    if (tiling.whole || crossing != Crossing::Cut) append(out, particles, i);
    for (const Vec3& move : tiling.moves) {
      append(out, particles, i);
      out.particles.position.back() += move;
    }
    out.fraction += tiling.volume / particles.box.prod();
  }
  return out;
}

}  // namespace terrazzo::exporting

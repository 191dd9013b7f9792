#include "nodes/bodies/carve/carve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/bodies/carve/atlas.h"
#include "nodes/bodies/carve/level_set.h"
#include "nodes/bodies/carve/subdivide.h"
#include "nodes/bodies/carve/surface_color.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/vertex_normals.h"
#include "nodes/common/stereology/shape_measures.h"
#include "runtime/memory.h"

namespace terrazzo::carve {
namespace {

Vec3 face_normal(const Mesh& mesh, std::size_t t) {
  const auto at = [&](int k) { return mesh.vertices[mesh.triangles[t][k]]; };
  const Vec3 n = (at(1) - at(0)).cross(at(2) - at(0));
  return n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::UnitZ());
}

// Smooth normals; z at vertices without area.
std::vector<Vec3f> smooth_normals(const Mesh& mesh) {
  std::vector<Vec3f> out;
  for (const Vec3& n : vertex_normals(mesh))
    out.push_back(n.isZero() ? Vec3f(Vec3f::UnitZ()) : Vec3f(n.cast<float>()));
  return out;
}

// Dual contouring cuts off edges and corners of the box; moves those vertices there.
void sharpen(Mesh& mesh, const Eigen::AlignedBox3d& box, double near) {
  if (box.isEmpty()) return;
  for (Vec3& v : mesh.vertices) {
    Vec3 moved = v;
    int planes = 0;
    for (int k = 0; k < 3; ++k)
      for (const double plane : {box.min()[k], box.max()[k]})
        if (std::abs(v[k] - plane) < near) {
          moved[k] = plane;
          ++planes;
        }
    if (planes >= 2) v = moved;
  }
}

void require_room(const carving::BodyParts& parts, double mm, double edge, std::uint64_t memory) {
  double area = 0;
  for (const Mesh* m : {&parts.base.mesh, &parts.removed, &parts.kept}) area += mesh_surface_area(*m);
  // About three triangles and seven voxels per square of the edge, with their lists.
  require_memory(600 * area * mm * mm / (edge * edge), memory,
                 fmt::format("a surface with edges of {:g} mm", edge));
}

// Volume, area and calipers of the mesh itself; the largest section from few directions if it is fine.
Shape measured(const std::string& name, Mesh mesh, bool smooth) {
  if (const auto faults = mesh_faults(mesh); !faults.empty())
    throw Error("open-mesh", "the surface of '" + name + "' is not closed: " + faults[0],
                "change edge, or repair the object");
  Shape s;
  s.name = name;
  s.smooth = smooth;
  s.volume = mesh_volume(mesh);
  s.surface_area = mesh_surface_area(mesh);
  s.mean_caliper = mesh_mean_caliper(mesh);
  s.max_section_area = quick_max_section_area(mesh);
  s.mesh = std::move(mesh);
  return s;
}

// The surface of a body in world units, and its level set in mm with this spacing.
Mesh make_surface(const carving::BodyParts& parts, double mm, double spacing, Volume& volume,
                  const Work& work) {
  const double edge = spacing / mm;
  Mesh mesh;  // world units
  if (parts.whole()) {
    mesh = parts.base.mesh;
    subdivide(mesh, edge, work);
    Mesh sized = mesh;
    transform(sized, Mat3::Identity() * mm, Vec3::Zero());
    volume = level_set(sized, spacing, work);
  } else {
    volume = level_set(parts, mm, spacing, work);
    mesh = surface_of(volume);
    transform(mesh, Mat3::Identity() / mm, Vec3::Zero());
    sharpen(mesh, parts.box, 0.6 * edge);
  }
  return mesh;
}

// The colors of the vertices. Moves those that are close to the surface onto it if `move`.
std::vector<Vec3f> color_vertices(Mesh& mesh, const SurfaceColor& colors, float reach, bool move,
                                  const Work& work) {
  const auto normals = smooth_normals(mesh);
  std::vector<Vec3f> color(mesh.vertices.size());
  work.parallel(mesh.vertices.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      Vec3f p = mesh.vertices[v].cast<float>();
      const Vec3f before = p;
      color[v] = colors.at(p, normals[v], reach);
      if (move && (p - before).norm() < 0.5f * reach) mesh.vertices[v] = p.cast<double>();
    }
  });
  return color;
}

}  // namespace

CarvedMesh carve_mesh(const carving::BodyParts& parts, const carving::Body& body, const CarveOptions& options,
                      const Work& work) {
  const double mm = body.mm;
  Eigen::AlignedBox3d bounds = parts.box;
  if (bounds.isEmpty())
    for (const Vec3& v : parts.base.mesh.vertices) bounds.extend(v);
  CarvedMesh out;
  out.edge = options.edge > 0 ? options.edge : bounds.sizes().maxCoeff() * mm / 200;
  const double edge = out.edge / mm;  // world units
  require_room(parts, mm, out.edge, options.memory);

  Mesh mesh = make_surface(parts, mm, out.edge, out.volume, work);
  work.progress(0.3);

  // An exact surface stays where it is; one from a grid moves onto the surface that RenderSolid shows.
  const SurfaceColor colors(*body.solid, *body.paint);
  const float reach = parts.whole() ? 0.02 * edge : edge;
  std::vector<Vec3f> color = color_vertices(mesh, colors, reach, !parts.whole(), work.part(0.3, 0.6));
  std::vector<CornerUv> uv;
  if (options.texture > 0)
    out.texture = bake_atlas(
        mesh, options.texture,
        [&](std::size_t t, const Vec3& at) {
          Vec3f p = at.cast<float>();
          return colors.at(p, face_normal(mesh, t).cast<float>(), reach);
        },
        uv, work.part(0.6, 0.8));
  else {
    Vec3 mean = Vec3::Zero();
    for (const Vec3f& c : color) mean += c.cast<double>() / double(color.size());
    out.texture = Image(1, 1, 1, 1, mean.cast<float>());
  }
  add_colors(
      out.volume,
      [&](const Vec3& at, const Vec3& normal) {
        Vec3f p = (at / mm).cast<float>();
        return colors.at(p, normal.cast<float>(), edge);
      },
      work.part(0.8, 0.95));

  transform(mesh, Mat3::Identity() * mm, Vec3::Zero());
  const Vec3 middle = mesh_centroid(mesh);
  transform(mesh, Mat3::Identity(), -middle);
  move(out.volume, -middle);
  out.shape = measured(parts.base.name, std::move(mesh), parts.base.smooth || !parts.whole());
  out.shape.color = std::move(color);
  out.shape.uv = std::move(uv);
  return out;
}

}  // namespace terrazzo::carve

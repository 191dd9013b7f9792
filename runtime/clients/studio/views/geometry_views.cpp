#include "runtime/clients/studio/views/geometry_views.h"

#include <fmt/format.h>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/reduce.h"
#include "nodes/common/geometry/mesh/render_mesh.h"
#include "runtime/clients/studio/views/view_bytes.h"

namespace terrazzo::studio {
namespace {

constexpr std::size_t kMostParticles = 400'000;
constexpr std::size_t kMostIndices = 12'000'000;

void append(std::string& out, const Vec3& v) {
  for (int k = 0; k < 3; ++k) studio::append(out, static_cast<float>(v[k]));
}
using studio::append;

// The shape with about that many triangles, or as it is if its mesh is not one that can be reduced.
Shape reduced(const Shape& shape, std::size_t triangles) {
  if (shape.mesh.triangles.size() <= triangles || !shape.color.empty() || !shape.uv.empty()) return shape;
  Shape out = shape;
  try {
    reduce_triangles(out.mesh, triangles);
  } catch (const Error&) {
    return shape;
  }
  out.smooth = shape.smooth;
  return out;
}

}  // namespace

std::string particles_view(const Particles& p) {
  if (p.count() > kMostParticles)
    throw Error("too-large",
                fmt::format("a page shows up to {} particles, and these are {}", kMostParticles, p.count()),
                "RenderSolid and Section show all of them");
  std::string out;
  out.reserve(20 + 48 * p.count());
  append(out, static_cast<std::uint32_t>(p.count()));
  append(out, std::uint32_t{44});
  append(out, p.box);
  for (std::size_t i = 0; i < p.count(); ++i) {
    append(out, p.position[i]);
    const Quat& q = p.orientation[i];
    for (const double v : {q.x(), q.y(), q.z(), q.w(), p.scale[i], p.size[i]})
      append(out, static_cast<float>(v));
    append(out, static_cast<std::uint32_t>(p.shape[i]));
    append(out, p.is_void(i) ? rgba(p.color[i]) & 0xffffffu : rgba(p.color[i]));
  }
  return out;
}

std::string shapes_view(const Shapes& shapes, int triangles) {
  std::string out;
  std::size_t indices = 0;
  append(out, static_cast<std::uint32_t>(shapes.shapes.size()));
  for (const Shape& shape : shapes.shapes) {
    const RenderMesh m = render_mesh(reduced(shape, static_cast<std::size_t>(std::max(triangles, 12))));
    if ((indices += m.indices.size()) > kMostIndices)
      throw Error("too-large",
                  fmt::format("these shapes have more than {} million triangles", kMostIndices / 3'000'000),
                  "RenderSolid shows them");
    append(out, static_cast<std::uint32_t>(m.positions.size()));
    append(out, static_cast<std::uint32_t>(m.indices.size()));
    append(out, static_cast<std::uint32_t>(shape.mesh.triangles.size()));
    append(out, std::uint32_t{shape.color.size() == shape.mesh.vertices.size() && !shape.color.empty()});
    for (const Vec3& v : m.positions) append(out, v);
    for (const Vec3& v : m.normals) append(out, v);
    for (const std::uint32_t i : m.indices) append(out, i);
    if (shape.color.size() == shape.mesh.vertices.size())
      for (const std::uint32_t v : m.vertex) append(out, rgba(shape.color[v]));
  }
  return out;
}

}  // namespace terrazzo::studio

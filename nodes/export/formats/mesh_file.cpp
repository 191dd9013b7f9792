#include "nodes/export/formats/mesh_file.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "graph/text/utf8.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/common/texture/color.h"
#include "runtime/codec.h"

namespace terrazzo::exporting {
namespace {

std::string obj(const Shapes& shapes) {
  std::string out = "# Terrazzo, mm\n";
  std::size_t first = 1;
  for (const Shape& s : shapes.shapes) {
    const std::string name = printable(s.name, std::string::npos);
    out += fmt::format("o {}\n", name.empty() ? "shape" : name);
    for (std::size_t i = 0; i < s.mesh.vertices.size(); ++i) {
      const Vec3& v = s.mesh.vertices[i];
      out += fmt::format("v {} {} {}", v.x(), v.y(), v.z());
      if (!s.color.empty()) {
        const Vec3f c = linear_to_srgb(s.color[i].cwiseMax(0.0f).cwiseMin(1.0f));
        out += fmt::format(" {:.4g} {:.4g} {:.4g}", c.x(), c.y(), c.z());
      }
      out += '\n';
    }
    for (const Triangle& t : s.mesh.triangles)
      out += fmt::format("f {} {} {}\n", first + t[0], first + t[1], first + t[2]);
    first += s.mesh.vertices.size();
  }
  return out;
}

std::string binary_ply(const Shape& shape) {
  const Mesh& mesh = shape.mesh;
  BufferWriter body;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    body.bytes(mesh.vertices[i].data(), 3 * sizeof(double));
    if (shape.color.empty()) continue;
    const Vec3f c = linear_to_srgb(shape.color[i].cwiseMax(0.0f).cwiseMin(1.0f));
    for (int k = 0; k < 3; ++k) body.pod(static_cast<std::uint8_t>(std::lround(255 * c[k])));
  }
  for (const Triangle& t : mesh.triangles) body.pod<std::uint8_t>(3), body.pod(t);
  return fmt::format(
             "ply\nformat binary_little_endian 1.0\ncomment Terrazzo, mm\nelement vertex {}\nproperty double "
             "x\n"
             "property double y\nproperty double z\n{}element face {}\nproperty list uchar int "
             "vertex_indices\nend_header\n",
             mesh.vertices.size(),
             shape.color.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n",
             mesh.triangles.size()) +
         std::string(body.buffer.begin(), body.buffer.end());
}

std::string binary_stl(const Mesh& mesh) {
  BufferWriter out;
  char header[80] = "Terrazzo, mm";
  out.bytes(header, sizeof header);
  out.pod(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    const Vec3 n = (b - a).cross(c - a);
    for (const Vec3& v : {n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero()), a, b, c}) {
      const Vec3f f = v.cast<float>();
      out.bytes(f.data(), 3 * sizeof(float));
    }
    out.pod<std::uint16_t>(0);
  }
  return {out.buffer.begin(), out.buffer.end()};
}

}  // namespace

void write_mesh(const std::filesystem::path& path, const Shapes& shapes) {
  if (shapes.shapes.empty()) throw Error("no-shapes", "there are no shapes to write");
  if (path.extension() == ".obj") return write_bytes(path, obj(shapes));
  if (shapes.shapes.size() > 1)
    throw Error("one-shape-only",
                fmt::format("a {} file holds one mesh, but there are {} shapes", path.extension().string(),
                            shapes.shapes.size()),
                "use .obj or .glb");
  write_bytes(path,
              path.extension() == ".ply" ? binary_ply(shapes.shapes[0]) : binary_stl(shapes.shapes[0].mesh));
}

}  // namespace terrazzo::exporting

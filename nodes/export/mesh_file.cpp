#include "nodes/export/mesh_file.h"

#include <fmt/format.h>

#include <cstring>

#include "nodes/common/io/checked_file.h"
#include "runtime/codec.h"

namespace terrazzo::exporting {
namespace {

std::string obj(const Shapes& shapes) {
  std::string out = "# Terrazzo, mm\n";
  std::size_t first = 1;
  for (const Shape& s : shapes.shapes) {
    out += fmt::format("o {}\n", s.name.empty() ? "shape" : s.name);
    for (const Vec3& v : s.mesh.vertices) out += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
    for (const Triangle& t : s.mesh.triangles)
      out += fmt::format("f {} {} {}\n", first + t[0], first + t[1], first + t[2]);
    first += s.mesh.vertices.size();
  }
  return out;
}

std::string binary_ply(const Mesh& mesh) {
  BufferWriter body;
  for (const Vec3& v : mesh.vertices) body.bytes(v.data(), 3 * sizeof(double));
  for (const Triangle& t : mesh.triangles) body.pod<std::uint8_t>(3), body.pod(t);
  return fmt::format(
             "ply\nformat binary_little_endian 1.0\ncomment Terrazzo, mm\nelement vertex {}\nproperty double "
             "x\n"
             "property double y\nproperty double z\nelement face {}\nproperty list uchar int "
             "vertex_indices\nend_header\n",
             mesh.vertices.size(), mesh.triangles.size()) +
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
  write_bytes(path, path.extension() == ".ply" ? binary_ply(shapes.shapes[0].mesh)
                                               : binary_stl(shapes.shapes[0].mesh));
}

}  // namespace terrazzo::exporting

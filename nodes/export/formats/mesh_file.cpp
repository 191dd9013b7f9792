#include "nodes/export/formats/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "graph/text/utf8.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/common/texture/color.h"
#include "nodes/export/instances.h"
#include "runtime/codec.h"

namespace terrazzo::exporting {
namespace {

// The meshes of a file: `get(i)` makes one, which is gone with the next.
struct Bodies {
  std::size_t count = 0;
  std::function<const Shape&(std::size_t)> get;
};

std::array<int, 3> bytes_of(const Vec3f& linear) {
  const Vec3f c = linear_to_srgb(linear.cwiseMax(0.0f).cwiseMin(1.0f));
  return {round_nearest(255 * c.x()), round_nearest(255 * c.y()), round_nearest(255 * c.z())};
}

void write_obj(std::ostream& out, const Bodies& bodies, const Work& work) {
  out << "# Terrazzo, mm\n";
  std::size_t first = 1;
  for (std::size_t b = 0; b < bodies.count; ++b) {
    work.check();
    work.done(b, bodies.count);
    const Shape& s = bodies.get(b);
    const std::string name = printable(s.name, std::string::npos);
    std::string text = fmt::format("o {}\n", name.empty() ? "shape" : name);
    for (std::size_t i = 0; i < s.mesh.vertices.size(); ++i) {
      const Vec3& v = s.mesh.vertices[i];
      text += fmt::format("v {} {} {}", v.x(), v.y(), v.z());
      if (!s.color.empty()) {
        const Vec3f c = linear_to_srgb(s.color[i].cwiseMax(0.0f).cwiseMin(1.0f));
        text += fmt::format(" {:.4g} {:.4g} {:.4g}", c.x(), c.y(), c.z());
      }
      text += '\n';
    }
    for (const Triangle& t : s.mesh.triangles)
      text += fmt::format("f {} {} {}\n", first + t[0], first + t[1], first + t[2]);
    first += s.mesh.vertices.size();
    out << text;
  }
}

struct Totals {
  std::size_t vertices = 0, triangles = 0;
  bool colored = false;
};

void write_ply(std::ostream& out, const Bodies& bodies, const Totals& totals, const Work& work) {
  out << fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment Terrazzo, mm\nelement vertex {}\nproperty double x\n"
      "property double y\nproperty double z\n{}element face {}\nproperty list uchar int "
      "vertex_indices\nend_header\n",
      totals.vertices,
      totals.colored ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "",
      totals.triangles);
  for (std::size_t b = 0; b < bodies.count; ++b) {
    work.check();
    work.done(b, 2 * bodies.count);
    const Shape& shape = bodies.get(b);
    BufferWriter points;
    for (std::size_t i = 0; i < shape.mesh.vertices.size(); ++i) {
      points.bytes(shape.mesh.vertices[i].data(), 3 * sizeof(double));
      if (totals.colored)
        for (const int c : bytes_of(shape.color[i])) points.pod(static_cast<std::uint8_t>(c));
    }
    out.write(points.buffer.data(), points.buffer.size());
  }
  std::int32_t first = 0;
  for (std::size_t b = 0; b < bodies.count; ++b) {
    work.check();
    work.done(bodies.count + b, 2 * bodies.count);
    const Mesh& mesh = bodies.get(b).mesh;
    BufferWriter faces;
    for (const Triangle& t : mesh.triangles) {
      faces.pod<std::uint8_t>(3);
      for (const std::int32_t v : t) faces.pod(first + v);
    }
    out.write(faces.buffer.data(), faces.buffer.size());
    first += count_of(mesh.vertices);
  }
}

void write_stl(std::ostream& out, const Bodies& bodies, const Totals& totals, const Work& work) {
  BufferWriter head;
  char header[80] = "Terrazzo, mm";
  head.bytes(header, sizeof header);
  head.pod(static_cast<std::uint32_t>(totals.triangles));
  out.write(head.buffer.data(), head.buffer.size());
  for (std::size_t i = 0; i < bodies.count; ++i) {
    work.check();
    work.done(i, bodies.count);
    const Mesh& mesh = bodies.get(i).mesh;
    BufferWriter body;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
      const Vec3 n = (b - a).cross(c - a);
      for (const Vec3& v : {n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero()), a, b, c}) {
        const Vec3f f = v.cast<float>();
        body.bytes(f.data(), 3 * sizeof(float));
      }
      body.pod<std::uint16_t>(0);
    }
    out.write(body.buffer.data(), body.buffer.size());
  }
}

void write(const std::filesystem::path& path, const Bodies& bodies, const Totals& totals, const Work& work) {
  const std::string extension = path.extension().string();
  const std::size_t most = extension == ".stl" ? 0xffffffffu : 0x7fffffffu;
  if (extension != ".obj" && std::max(totals.vertices, totals.triangles) > most)
    throw Error("too-large",
                fmt::format("the packing has {} vertices and {} triangles; a {} file holds {}",
                            totals.vertices, totals.triangles, extension, most),
                "use shapes with fewer triangles, or .glb");
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    if (extension == ".obj") return write_obj(out, bodies, work);
    extension == ".ply" ? write_ply(out, bodies, totals, work) : write_stl(out, bodies, totals, work);
  });
}

}  // namespace

void write_mesh(const std::filesystem::path& path, const Shapes& shapes) {
  if (shapes.shapes.empty()) throw Error("no-shapes", "there are no shapes to write");
  if (path.extension() != ".obj" && shapes.shapes.size() > 1)
    throw Error("one-shape-only",
                fmt::format("a {} file holds one mesh, but there are {} shapes", path.extension().string(),
                            shapes.shapes.size()),
                "use .obj or .glb");
  const Mesh& mesh = shapes.shapes[0].mesh;
  write(path, {shapes.shapes.size(), [&](std::size_t i) -> const Shape& { return shapes.shapes[i]; }},
        {mesh.vertices.size(), mesh.triangles.size(), !shapes.shapes[0].color.empty()}, {});
}

void write_mesh(const std::filesystem::path& path, const Particles& particles, const Shapes& shapes,
                const Work& work) {
  instances_of(particles, shapes);  // checks them
  std::vector<std::size_t> solid;
  Totals totals{0, 0, true};
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (particles.is_void(i)) continue;
    solid.push_back(i);
    totals.vertices += shapes.shapes[particles.shape[i]].mesh.vertices.size();
    totals.triangles += shapes.shapes[particles.shape[i]].mesh.triangles.size();
  }
  Shape placed;
  const auto get = [&](std::size_t n) -> const Shape& {
    const std::size_t i = solid[n];
    const Shape& shape = shapes.shapes[particles.shape[i]];
    placed.name = fmt::format("{}_{}", shape.name, i);
    placed.mesh = shape.mesh;
    transform(placed.mesh, particles.orientation[i].normalized().toRotationMatrix() * particles.scale[i],
              particles.position[i]);
    placed.color = shape.color;
    if (placed.color.empty()) placed.color.assign(shape.mesh.vertices.size(), particles.color[i]);
    return placed;
  };
  write(path, {solid.size(), get}, totals, work);
}

}  // namespace terrazzo::exporting

#include "nodes/export/scene_parts.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/render_mesh.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/data/indices.h"
#include "nodes/export/color_classes.h"
#include "nodes/export/instances.h"
#include "runtime/codec.h"
#include "runtime/memory.h"

namespace terrazzo::exporting {

Vec3 Scene::eye() const {
  // The sphere around the box fits into the view.
  const double distance = particles->box.norm() / 2 / std::sin(kSceneViewAngle / 2 * std::numbers::pi / 180);
  return center() + distance * Vec3(0.5, -0.75, 0.45).normalized();
}

Scene scene_of(const Particles& particles, const Shapes& shapes, const std::string& stem, int most_colors) {
  if (std::any_of(stem.begin(), stem.end(),
                  [](char c) { return c == '"' || c == '\\' || (static_cast<unsigned char>(c) < 32); }))
    throw Error("bad-names", "the file name contains quotes, backslashes or control characters", "rename it")
        .parameter("path");
  const auto members = instances_of(particles, shapes);
  Scene out;
  out.particles = &particles;
  out.shapes = &shapes;
  std::vector<Vec3f> colors;
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i)) colors.push_back(particles.color[i]);
  const ColorClasses classes = color_classes(colors, most_colors);
  out.colors = classes.color;
  out.group.assign(particles.count(), -1);
  std::map<std::pair<std::int32_t, int>, int> known;
  std::size_t solid = 0;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (particles.is_void(i)) continue;
    const int color = classes.of[solid++];
    const auto [it, first] = known.emplace(std::pair(particles.shape[i], color), count_of(out.groups));
    if (first) out.groups.push_back({static_cast<std::size_t>(particles.shape[i]), color});
    out.group[i] = it->second;
  }
  for (std::size_t s = 0; s < shapes.shapes.size(); ++s)
    out.mesh_files.push_back(members[s].empty() ? "" : fmt::format("{}_{}.ply", stem, s));
  return out;
}

BinderMedium binder_medium(const Volume& volume, std::uint64_t memory, const Work& work) {
  BinderMedium out;
  out.box = voxel_box(volume);
  // The values, a grid of them, and the file.
  require_memory(16.0 * out.box.count(), memory, "the medium of the binder");
  const VoxelSource density(volume, "density", out.box);
  if (density.components() != 1 || density.whole())
    throw Error("unsupported-grid", "the grid density does not contain single real numbers",
                "connect Voxelize.volume");
  out.density.resize(out.box.count());
  const std::size_t plane = out.box.plane();
  for (int z = 0; z < out.box.size.z(); ++z) {
    work.check();
    density.read(z, z + 1, &out.density[plane * z]);
  }
  for (float& d : out.density) d = 1 - std::clamp(d, 0.0f, 1.0f);
  out.extinction = 20 / out.box.size.cast<double>().cwiseProduct(out.box.spacing).maxCoeff();
  return out;
}

void write_render_ply(const std::filesystem::path& path, const Shape& shape) {
  const RenderMesh mesh = render_mesh(shape);
  BufferWriter body;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    for (const Vec3& v : {mesh.positions[i], mesh.normals[i]}) {
      const Vec3f f = v.cast<float>();
      body.bytes(f.data(), 3 * sizeof(float));
    }
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    body.pod<std::uint8_t>(3);
    for (std::size_t k = 0; k < 3; ++k)
      body.pod<std::int32_t>(static_cast<std::int32_t>(mesh.indices[t + k]));
  }
  write_bytes(path,
              fmt::format("ply\nformat binary_little_endian 1.0\ncomment Terrazzo, mm\nelement vertex {}\n"
                          "property float x\nproperty float y\nproperty float z\n"
                          "property float nx\nproperty float ny\nproperty float nz\n"
                          "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                          mesh.positions.size(), mesh.indices.size() / 3) +
                  std::string(body.buffer.begin(), body.buffer.end()));
}

std::array<double, 16> instance_matrix(const Particles& p, std::size_t i) {
  const Eigen::Matrix3d m = p.orientation[i].normalized().toRotationMatrix() * p.scale[i];
  std::array<double, 16> out{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) out[4 * r + c] = m(r, c);
    out[4 * r + 3] = p.position[i][r];
  }
  out[15] = 1;
  return out;
}

}  // namespace terrazzo::exporting

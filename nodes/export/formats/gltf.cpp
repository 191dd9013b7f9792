#include "nodes/export/formats/gltf.h"

#include <algorithm>
#include <array>
#include <map>

#include "nodes/export/color_classes.h"
#include "nodes/export/formats/gltf_packer.h"
#include "nodes/export/instances.h"

namespace terrazzo::exporting {
namespace {

using Gltf = tinygltf::Value;
using Members = std::vector<std::vector<std::size_t>>;

// Rotation about y-up axes: x, y, z, w.
std::array<double, 4> y_up_rotation(const Quat& orientation) {
  const Quat q = orientation.normalized();
  const Vec3 axis = y_up(q.vec());
  return {axis.x(), axis.y(), axis.z(), q.w()};
}

std::size_t index_of(const std::vector<std::int32_t>& index, std::size_t i) {
  return index.empty() ? i : index[i];
}

void add_instanced(GltfPacker& pack, const Particles& particles, const Shapes& shapes, const Members& members,
                   const std::vector<std::int32_t>& index, const Work& work) {
  pack.model.extensionsUsed = {"EXT_mesh_gpu_instancing"};
  // A reader without the extension must report an error, not show one particle at the origin.
  pack.model.extensionsRequired = {"EXT_mesh_gpu_instancing"};
  pack.material("particle", Vec3f::Ones());
  for (std::size_t s = 0; s < members.size(); ++s) {
    work.check();
    if (members[s].empty()) continue;
    std::vector<float> translation, rotation, scale, color, id;
    for (const std::size_t i : members[s]) {
      const Vec3 p = y_up(particles.position[i]) * kMetersPerMm;
      for (int k = 0; k < 3; ++k) {
        translation.push_back(float(p[k]));
        scale.push_back(float(particles.scale[i]));
        color.push_back(particles.color[i][k]);
      }
      for (const double q : y_up_rotation(particles.orientation[i])) rotation.push_back(float(q));
      id.push_back(float(index_of(index, i)));
    }
    tinygltf::Node node;
    node.name = shapes.shapes[s].name;
    node.mesh = pack.mesh(shapes.shapes[s].name, pack.primitive(shapes.shapes[s]));
    Gltf::Object attributes;
    attributes["TRANSLATION"] = Gltf(pack.floats(translation, 3, 0));
    attributes["ROTATION"] = Gltf(pack.floats(rotation, 4, 0));
    attributes["SCALE"] = Gltf(pack.floats(scale, 3, 0));
    attributes["_COLOR_0"] = Gltf(pack.floats(color, 3, 0));
    attributes["_ID"] = Gltf(pack.floats(id, 1, 0));
    Gltf::Object extension;
    extension["attributes"] = Gltf(std::move(attributes));
    node.extensions["EXT_mesh_gpu_instancing"] = Gltf(std::move(extension));
    pack.root(pack.node(std::move(node)));
  }
}

void add_nodes(GltfPacker& pack, const Particles& particles, const Shapes& shapes, const Members& members,
               int materials, const std::vector<std::int32_t>& index, const Work& work) {
  std::vector<Vec3f> colors;
  for (const auto& of_shape : members)
    for (const std::size_t i : of_shape) colors.push_back(particles.color[i]);
  const ColorClasses classes = color_classes(colors, materials);
  for (std::size_t c = 0; c < classes.color.size(); ++c)
    pack.material("color_" + std::to_string(c), classes.color[c]);

  tinygltf::Node all;
  all.name = "particles";
  std::size_t next = 0;  // color
  for (std::size_t s = 0; s < members.size(); ++s) {
    if (members[s].empty()) continue;
    const Shape& shape = shapes.shapes[s];
    tinygltf::Primitive primitive = pack.primitive(shape);
    std::map<int, int> meshes;  // by color class: a mesh has one material, but all share the shape's buffers
    for (const std::size_t i : members[s]) {
      if (next % 1024 == 0) work.check();
      const int c = classes.of[next++];
      const auto [mesh, added] = meshes.emplace(c, 0);
      if (added) {
        primitive.material = c;
        mesh->second = pack.mesh(shape.name + "_color_" + std::to_string(c), primitive);
      }
      tinygltf::Node node;
      node.name = shape.name + "_" + std::to_string(i);
      node.mesh = mesh->second;
      const Vec3 p = y_up(particles.position[i]) * kMetersPerMm;
      const auto q = y_up_rotation(particles.orientation[i]);
      node.translation = {p.x(), p.y(), p.z()};
      node.rotation.assign(q.begin(), q.end());
      node.scale.assign(3, particles.scale[i]);
      const Vec3f& color = particles.color[i];
      Gltf::Object extras;
      extras["id"] = Gltf(static_cast<int>(index_of(index, i)));
      extras["class"] = Gltf(particles.cls[i]);
      extras["size_mm"] = Gltf(particles.size[i]);
      extras["color"] =
          Gltf(Gltf::Array{Gltf(double(color.x())), Gltf(double(color.y())), Gltf(double(color.z()))});
      node.extras = Gltf(std::move(extras));
      all.children.push_back(pack.node(std::move(node)));
    }
  }
  pack.root(pack.node(std::move(all)));
}

}  // namespace

void write_glb(const std::filesystem::path& path, const Particles& particles, const Shapes& shapes,
               const std::string& provenance, const Work& work, Instancing instancing, int materials,
               const std::vector<std::int32_t>& index) {
  const Members members = instances_of(particles, shapes);
  GltfPacker pack;
  if (instancing == Instancing::Extension)
    add_instanced(pack, particles, shapes, members, index, work);
  else
    add_nodes(pack, particles, shapes, members, materials, index, work);
  pack.write(path, provenance);
}

void write_glb(const std::filesystem::path& path, const Shapes& shapes, const std::string& provenance,
               const Work& work, const Image* texture) {
  if (shapes.shapes.empty()) throw Error("no-shapes", "there are no shapes to write");
  GltfPacker pack;
  pack.material("particle", Vec3f::Ones());
  int textured = -1;
  if (texture) {
    if (std::all_of(shapes.shapes.begin(), shapes.shapes.end(), [](const Shape& s) { return s.uv.empty(); }))
      throw Error("no-uv", "an image is connected, but no shape has texture coordinates",
                  "set texture of Carve, or disconnect the image");
    textured = pack.textured_material("texture", *texture);
  }
  double x = 0;  // mm, start of the next shape
  for (const Shape& shape : shapes.shapes) {
    work.check();
    tinygltf::Node node;
    node.name = shape.name;
    tinygltf::Primitive primitive = pack.primitive(shape, texture != nullptr);
    if (texture && !shape.uv.empty()) primitive.material = textured;
    node.mesh = pack.mesh(shape.name, primitive);
    Eigen::AlignedBox3d box;
    for (const Vec3& v : shape.mesh.vertices) box.extend(v);
    const double shift = shapes.shapes.size() == 1 ? 0 : x - box.min().x();
    if (shift != 0) node.translation = {shift * kMetersPerMm, 0, 0};
    x += 1.2 * box.sizes().x();
    pack.root(pack.node(std::move(node)));
  }
  pack.write(path, provenance);
}

}  // namespace terrazzo::exporting

#include "nodes/export/gltf.h"

#include <tiny_gltf.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "nodes/common/geometry/render_mesh.h"
#include "nodes/common/io/checked_file.h"

namespace terrazzo::exporting {
namespace {

constexpr double metres_per_mm = 0.001;
constexpr std::size_t largest_buffer = 0xfff00000u;  // lengths in a .glb have 32 bits

Vec3 y_up(const Vec3& v) { return {v.x(), v.z(), -v.y()}; }

tinygltf::Value gltf_value(const nlohmann::json& j) {
  using tinygltf::Value;
  switch (j.type()) {
    case nlohmann::json::value_t::boolean:
      return Value(j.get<bool>());
    case nlohmann::json::value_t::number_integer:
    case nlohmann::json::value_t::number_unsigned: {
      const double v = j.get<double>();
      return std::abs(v) < 2147483647.0 ? Value(static_cast<int>(v)) : Value(v);
    }
    case nlohmann::json::value_t::number_float:
      return Value(j.get<double>());
    case nlohmann::json::value_t::string:
      return Value(j.get<std::string>());
    case nlohmann::json::value_t::array: {
      Value::Array out;
      for (const auto& v : j) out.push_back(gltf_value(v));
      return Value(std::move(out));
    }
    case nlohmann::json::value_t::object: {
      Value::Object out;
      for (const auto& [key, v] : j.items()) out[key] = gltf_value(v);
      return Value(std::move(out));
    }
    default:
      return Value(std::string());
  }
}

// Fills the single buffer of a model and creates accessors to it.
class Packer {
 public:
  Packer() {
    model.buffers.emplace_back();
    model.asset.version = "2.0";
    model.asset.generator = "Terrazzo";
    tinygltf::Material material;
    material.name = "particle";
    material.pbrMetallicRoughness.baseColorFactor = {1, 1, 1, 1};
    material.pbrMetallicRoughness.metallicFactor = 0;
    material.pbrMetallicRoughness.roughnessFactor = 0.6;
    model.materials.push_back(material);
    model.scenes.emplace_back();
    model.defaultScene = 0;
  }

  // `components` floats per element. `target`: TINYGLTF_TARGET_ARRAY_BUFFER, or 0 for instance data.
  int floats(const std::vector<float>& data, int components, int target, bool bounds = false) {
    tinygltf::Accessor a;
    a.bufferView = view(data.data(), data.size() * sizeof(float), target);
    a.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    a.type = components == 1   ? TINYGLTF_TYPE_SCALAR
             : components == 3 ? TINYGLTF_TYPE_VEC3
                               : TINYGLTF_TYPE_VEC4;
    a.count = data.size() / components;
    if (bounds) {
      a.minValues.assign(data.begin(), data.begin() + components), a.maxValues = a.minValues;
      for (std::size_t i = 0; i < data.size(); ++i) {
        a.minValues[i % components] = std::min(a.minValues[i % components], double(data[i]));
        a.maxValues[i % components] = std::max(a.maxValues[i % components], double(data[i]));
      }
    }
    return add(std::move(a));
  }

  int triangles(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
    tinygltf::Accessor a;
    if (vertices < 65535) {
      const std::vector<std::uint16_t> narrow(indices.begin(), indices.end());
      a.bufferView = view(narrow.data(), narrow.size() * 2, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
      a.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    } else {
      a.bufferView = view(indices.data(), indices.size() * 4, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
      a.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    }
    a.type = TINYGLTF_TYPE_SCALAR;
    a.count = indices.size();
    return add(std::move(a));
  }

  int mesh(const Shape& shape) {
    const RenderMesh m = render_mesh(shape);
    std::vector<float> position, normal;
    position.reserve(m.positions.size() * 3), normal.reserve(m.positions.size() * 3);
    for (std::size_t v = 0; v < m.positions.size(); ++v) {
      const Vec3 p = y_up(m.positions[v]) * metres_per_mm, n = y_up(m.normals[v]);
      for (int k = 0; k < 3; ++k) position.push_back(float(p[k])), normal.push_back(float(n[k]));
    }
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.material = 0;
    primitive.attributes["POSITION"] = floats(position, 3, TINYGLTF_TARGET_ARRAY_BUFFER, true);
    primitive.attributes["NORMAL"] = floats(normal, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
    primitive.indices = triangles(m.indices, m.positions.size());
    tinygltf::Mesh out;
    out.name = shape.name;
    out.primitives.push_back(std::move(primitive));
    model.meshes.push_back(std::move(out));
    return static_cast<int>(model.meshes.size()) - 1;
  }

  void node(tinygltf::Node n) {
    model.scenes[0].nodes.push_back(static_cast<int>(model.nodes.size()));
    model.nodes.push_back(std::move(n));
  }

  void write(const std::filesystem::path& path, const std::string& provenance) {
    if (!provenance.empty()) {
      const auto json = nlohmann::json::parse(provenance, nullptr, false);
      if (json.is_object()) model.asset.extras = gltf_value(json);
    }
    CheckedFile file(path);
    file.guard([&](std::ostream& out) {
      tinygltf::TinyGLTF writer;
      if (!writer.WriteGltfSceneToStream(&model, out, false, true))
        throw Error("write-failed", "the glTF file could not be serialized");
    });
  }

  tinygltf::Model model;

 private:
  int view(const void* data, std::size_t size, int target) {
    auto& bytes = model.buffers[0].data;
    bytes.resize((bytes.size() + 3) / 4 * 4);
    if (size > largest_buffer - bytes.size())
      throw Error("too-large", "the data exceeds 4 GiB, the limit of a .glb file",
                  "use fewer triangles per shape or fewer particles");
    tinygltf::BufferView v;
    v.buffer = 0;
    v.byteOffset = bytes.size();
    v.byteLength = size;
    v.target = target;
    const auto* p = static_cast<const unsigned char*>(data);
    bytes.insert(bytes.end(), p, p + size);
    model.bufferViews.push_back(std::move(v));
    return static_cast<int>(model.bufferViews.size()) - 1;
  }
  int add(tinygltf::Accessor a) {
    model.accessors.push_back(std::move(a));
    return static_cast<int>(model.accessors.size()) - 1;
  }
};

void check(const Particles& particles, const Shapes& shapes) {
  if (particles.count() == 0) throw Error("no-particles", "there are no particles to write");
  if (particles.void_count() == particles.count())
    throw Error("no-particles", "all particles are voids: there is nothing to write",
                "export the grid void of Voxelize instead");
  for (std::size_t i = 0; i < particles.count(); ++i) {
    const std::string who = "particle " + std::to_string(i);
    const auto s = particles.shape[i];
    if (s < 0 || static_cast<std::size_t>(s) >= shapes.shapes.size())
      throw Error("no-such-shape",
                  who + " has shape " + std::to_string(s) + ", but there are only " +
                      std::to_string(shapes.shapes.size()) + " shapes",
                  "connect the shapes used in the packing");
    if (!particles.position[i].allFinite() || !std::isfinite(particles.scale[i]) ||
        !particles.orientation[i].coeffs().allFinite() || !particles.color[i].allFinite() ||
        particles.orientation[i].norm() < 1e-9)
      throw Error("bad-number", who + " has an invalid position, orientation, scale or color");
  }
}

}  // namespace

void write_glb(const std::filesystem::path& path, const Particles& particles, const Shapes& shapes,
               const std::string& provenance, const Work& work) {
  check(particles, shapes);
  Packer pack;
  pack.model.extensionsUsed = {"EXT_mesh_gpu_instancing"};
  // A reader without the extension must report an error, not show one particle at the origin.
  pack.model.extensionsRequired = {"EXT_mesh_gpu_instancing"};
  std::vector<std::vector<std::size_t>> members(shapes.shapes.size());
  for (std::size_t i = 0; i < particles.count(); ++i)
    if (!particles.is_void(i)) members[particles.shape[i]].push_back(i);

  for (std::size_t s = 0; s < members.size(); ++s) {
    work.check();
    if (members[s].empty()) continue;
    std::vector<float> translation, rotation, scale, color, id;
    for (const std::size_t i : members[s]) {
      const Vec3 p = y_up(particles.position[i]) * metres_per_mm;
      const Quat q = particles.orientation[i].normalized();
      const Vec3 axis = y_up(q.vec());
      for (int k = 0; k < 3; ++k) {
        translation.push_back(float(p[k]));
        rotation.push_back(float(axis[k]));
        scale.push_back(float(particles.scale[i]));
        color.push_back(particles.color[i][k]);
      }
      rotation.push_back(float(q.w()));
      id.push_back(float(i));
    }
    tinygltf::Node node;
    node.name = shapes.shapes[s].name;
    node.mesh = pack.mesh(shapes.shapes[s]);
    using tinygltf::Value;
    Value::Object attributes;
    attributes["TRANSLATION"] = Value(pack.floats(translation, 3, 0));
    attributes["ROTATION"] = Value(pack.floats(rotation, 4, 0));
    attributes["SCALE"] = Value(pack.floats(scale, 3, 0));
    attributes["_COLOR_0"] = Value(pack.floats(color, 3, 0));
    attributes["_ID"] = Value(pack.floats(id, 1, 0));
    Value::Object extension;
    extension["attributes"] = Value(std::move(attributes));
    node.extensions["EXT_mesh_gpu_instancing"] = Value(std::move(extension));
    pack.node(std::move(node));
  }
  pack.write(path, provenance);
}

void write_glb(const std::filesystem::path& path, const Shapes& shapes, const std::string& provenance,
               const Work& work) {
  if (shapes.shapes.empty()) throw Error("no-shapes", "there are no shapes to write");
  Packer pack;
  double x = 0;  // mm, start of the next shape
  for (const Shape& shape : shapes.shapes) {
    work.check();
    tinygltf::Node node;
    node.name = shape.name;
    node.mesh = pack.mesh(shape);
    Eigen::AlignedBox3d box;
    for (const Vec3& v : shape.mesh.vertices) box.extend(v);
    const double shift = shapes.shapes.size() == 1 ? 0 : x - box.min().x();
    if (shift != 0) node.translation = {shift * metres_per_mm, 0, 0};
    x += 1.2 * box.sizes().x();
    pack.node(std::move(node));
  }
  pack.write(path, provenance);
}

}  // namespace terrazzo::exporting

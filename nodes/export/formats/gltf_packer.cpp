#include "nodes/export/formats/gltf_packer.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "nodes/common/geometry/mesh/render_mesh.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/data/indices.h"
#include "nodes/export/formats/picture_file.h"
#include "runtime/files/json_input.h"

namespace terrazzo::exporting {
namespace {

constexpr std::size_t kLargestBuffer = 0xfff00000u;  // lengths in a .glb have 32 bits

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

}  // namespace

GltfPacker::GltfPacker() {
  model.buffers.emplace_back();
  model.asset.version = "2.0";
  model.asset.generator = "Terrazzo";
  model.scenes.emplace_back();
  model.defaultScene = 0;
}

int GltfPacker::floats(const std::vector<float>& data, int components, int target, bool bounds) {
  tinygltf::Accessor a;
  a.bufferView = view(data.data(), data.size() * sizeof(float), target);
  a.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
  a.type =
      components == 1 ? TINYGLTF_TYPE_SCALAR : components;  // a vector's type is its number of components
  a.count = data.size() / components;
  if (bounds) {
    a.minValues.assign(data.begin(), data.begin() + components);
    a.maxValues = a.minValues;
    for (std::size_t i = 0; i < data.size(); ++i) {
      a.minValues[i % components] = std::min(a.minValues[i % components], double(data[i]));
      a.maxValues[i % components] = std::max(a.maxValues[i % components], double(data[i]));
    }
  }
  return add(std::move(a));
}

int GltfPacker::triangles(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
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

int GltfPacker::material(const std::string& name, const Vec3f& color) {
  tinygltf::Material m;
  m.name = name;
  const Vec3f c = color.cwiseMax(0.0f).cwiseMin(1.0f);
  m.pbrMetallicRoughness.baseColorFactor = {c.x(), c.y(), c.z(), 1};
  m.pbrMetallicRoughness.metallicFactor = 0;
  m.pbrMetallicRoughness.roughnessFactor = 0.6;
  model.materials.push_back(std::move(m));
  return count_of(model.materials) - 1;
}

int GltfPacker::texture(const std::string& name, const std::string& png) {
  tinygltf::Image image;
  image.name = name;
  image.mimeType = "image/png";
  image.bufferView = view(png.data(), png.size(), 0);
  model.images.push_back(std::move(image));
  tinygltf::Texture t;
  t.source = count_of(model.images) - 1;
  model.textures.push_back(t);
  return count_of(model.textures) - 1;
}

int GltfPacker::textured_material(const std::string& name, const Image& image) {
  const int at = material(name, Vec3f::Ones());
  model.materials.back().pbrMetallicRoughness.baseColorTexture.index = texture(name, png_of(image));
  return at;
}

tinygltf::Primitive GltfPacker::primitive(const Shape& shape, bool textured) {
  RenderMesh m = render_mesh(shape);
  std::vector<float> uv;
  if (textured && !shape.uv.empty()) {  // every corner has its own coordinates, so it is a vertex
    RenderMesh split;
    for (std::size_t i = 0; i < m.indices.size(); ++i) {
      split.positions.push_back(m.positions[m.indices[i]]);
      split.normals.push_back(m.normals[m.indices[i]]);
      split.indices.push_back(i);
      const Eigen::Vector2f& at = shape.uv[m.triangle[i / 3]][i % 3];
      uv.push_back(at.x());
      uv.push_back(at.y());
    }
    m = std::move(split);
  }
  std::vector<float> position, normal;
  position.reserve(m.positions.size() * 3);
  normal.reserve(m.positions.size() * 3);
  for (std::size_t v = 0; v < m.positions.size(); ++v) {
    const Vec3 p = y_up(m.positions[v]) * kMetersPerMm, n = y_up(m.normals[v]);
    for (int k = 0; k < 3; ++k) {
      position.push_back(float(p[k]));
      normal.push_back(float(n[k]));
    }
  }
  tinygltf::Primitive out;
  out.mode = TINYGLTF_MODE_TRIANGLES;
  out.material = 0;
  out.attributes["POSITION"] = floats(position, 3, TINYGLTF_TARGET_ARRAY_BUFFER, true);
  out.attributes["NORMAL"] = floats(normal, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
  if (!uv.empty()) {
    out.attributes["TEXCOORD_0"] = floats(uv, 2, TINYGLTF_TARGET_ARRAY_BUFFER);
  } else if (!shape.color.empty()) {
    std::vector<float> color;
    for (const std::uint32_t v : m.vertex)
      for (int k = 0; k < 3; ++k) color.push_back(std::clamp(shape.color[v][k], 0.0f, 1.0f));
    out.attributes["COLOR_0"] = floats(color, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
  }
  out.indices = triangles(m.indices, m.positions.size());
  return out;
}

int GltfPacker::mesh(const std::string& name, const tinygltf::Primitive& primitive) {
  tinygltf::Mesh out;
  out.name = name;
  out.primitives.push_back(primitive);
  model.meshes.push_back(std::move(out));
  return count_of(model.meshes) - 1;
}

int GltfPacker::node(tinygltf::Node n) {
  model.nodes.push_back(std::move(n));
  return count_of(model.nodes) - 1;
}

void GltfPacker::write(const std::filesystem::path& path, const std::string& provenance) {
  if (!provenance.empty()) {
    const auto json = json_or_null(provenance);
    if (json.is_object()) model.asset.extras = gltf_value(json);
  }
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    tinygltf::TinyGLTF writer;
    if (!writer.WriteGltfSceneToStream(&model, out, false, true))
      throw Error("write-failed", "the glTF file could not be serialized");
  });
}

int GltfPacker::view(const void* data, std::size_t size, int target) {
  auto& bytes = model.buffers[0].data;
  bytes.resize((bytes.size() + 3) / 4 * 4);
  if (size > kLargestBuffer - bytes.size())
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
  return count_of(model.bufferViews) - 1;
}

int GltfPacker::add(tinygltf::Accessor a) {
  model.accessors.push_back(std::move(a));
  return count_of(model.accessors) - 1;
}

}  // namespace terrazzo::exporting

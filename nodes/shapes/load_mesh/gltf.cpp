#include <fmt/format.h>
#include <tiny_gltf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "nodes/shapes/load_mesh/formats.h"
#include "nodes/shapes/load_mesh/mesh_text.h"

namespace terrazzo::load_mesh {
namespace {

// A model in memory takes up to this many bytes per byte of JSON.
constexpr double kJsonBytes = 300;
// The library reads nested values recursively.
constexpr int kDeepest = 100;
constexpr double kMillimeters = 1000;  // per meter, the unit of glTF

[[noreturn]] void bad(const std::string& what) {
  throw Error("bad-mesh", what, "the file is damaged: export it again");
}

[[noreturn]] void unsupported(const std::string& what, const std::string& hint) {
  throw Error("unreadable-mesh", what, hint);
}

void check_depth(std::string_view json) {
  int depth = 0;
  bool text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (text && c == '\\')
      ++i;
    else if (c == '"')
      text = !text;
    else if (!text && (c == '{' || c == '['))
      ++depth;
    else if (!text && (c == '}' || c == ']'))
      --depth;
    if (depth > kDeepest) damaged(fmt::format("its values are nested more than {} deep", kDeepest));
  }
}

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t out = 0;
  std::memcpy(&out, bytes.data() + at, sizeof out);
  return out;
}

// The JSON of a file: the first chunk of a binary one.
std::string_view json_of_gltf(std::string_view bytes, bool binary) {
  if (!binary) return bytes;
  if (bytes.size() < 20) damaged("is not a binary glTF file");
  const std::uint32_t length = word_at(bytes, 12);
  if (word_at(bytes, 4) != 2) damaged(fmt::format("is glTF version {}, not 2", word_at(bytes, 4)));
  if (word_at(bytes, 8) != bytes.size())
    damaged(fmt::format("its header says {} bytes, but the file has {}", word_at(bytes, 8), bytes.size()));
  if (length > bytes.size() - 20) damaged("its JSON ends beyond the file");
  return bytes.substr(20, length);
}

tinygltf::Model parsed(std::string_view bytes, bool binary) {
  tinygltf::TinyGLTF reader;
  // Only the file itself is read: no other file that it names, and no picture.
  tinygltf::FsCallbacks none{};
  none.FileExists = [](const std::string&, void*) { return false; };
  none.ExpandFilePath = [](const std::string& path, void*) { return path; };
  none.ReadWholeFile = [](std::vector<unsigned char>*, std::string*, const std::string&, void*) {
    return false;
  };
  none.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  reader.SetFsCallbacks(none);
  reader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                           const unsigned char*, int, void*) { return true; },
                        nullptr);
  tinygltf::Model model;
  std::string error, warning;
  const unsigned int size = bytes.size();
  const bool read =
      binary ? reader.LoadBinaryFromMemory(&model, &error, &warning,
                                           reinterpret_cast<const unsigned char*>(bytes.data()), size)
             : reader.LoadASCIIFromString(&model, &error, &warning, bytes.data(), size, "");
  for (const tinygltf::Buffer& b : model.buffers)
    if (!b.uri.empty() && b.data.empty())
      unsupported("its data is in another file, '" + printable(b.uri) + "'",
                  "export it as .glb, which holds everything");
  if (!read) {
    if (error.find("File not found") != std::string::npos ||
        error.find("file not found") != std::string::npos)
      unsupported("its data is in another file: " + printable(error),
                  "export it as .glb, which holds everything");
    damaged("is not a valid glTF file: " + (error.empty() ? "the JSON is damaged" : printable(error)));
  }
  return model;
}

// Numbers of an accessor, checked against the bytes of its buffer.
class AccessorReader {
 public:
  AccessorReader(const tinygltf::Model& model, int index, const std::string& what, int components)
      : components_(components) {
    if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size())
      bad(fmt::format("{} is accessor {} of {}", what, index, model.accessors.size()));
    const tinygltf::Accessor& a = model.accessors[index];
    if (a.sparse.isSparse) unsupported(what + " is a sparse accessor", "export it without sparse accessors");
    const int given = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(a.type));
    if (given != components)
      bad(fmt::format("{} has {} numbers per element instead of {}", what, given, components));
    type_ = a.componentType;
    normalized_ = a.normalized;
    count_ = a.count;
    const int size = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type_));
    if (size <= 0 || type_ == TINYGLTF_COMPONENT_TYPE_DOUBLE || type_ == TINYGLTF_COMPONENT_TYPE_INT)
      bad(fmt::format("{} has the component type {}", what, type_));
    size_ = size;
    if (a.bufferView < 0 || static_cast<std::size_t>(a.bufferView) >= model.bufferViews.size())
      bad(fmt::format("{} is in buffer view {} of {}", what, a.bufferView, model.bufferViews.size()));
    const tinygltf::BufferView& v = model.bufferViews[a.bufferView];
    if (v.buffer < 0 || static_cast<std::size_t>(v.buffer) >= model.buffers.size())
      bad(fmt::format("{} is in buffer {} of {}", what, v.buffer, model.buffers.size()));
    const auto& bytes = model.buffers[v.buffer].data;
    const std::size_t element = size_ * components;
    stride_ = v.byteStride > 0 ? v.byteStride : element;
    // Each difference is taken only after the comparison that makes it positive.
    if (v.byteOffset > bytes.size() || v.byteLength > bytes.size() - v.byteOffset ||
        a.byteOffset > v.byteLength || stride_ < element ||
        (count_ > 0 && (element > v.byteLength - a.byteOffset ||
                        count_ - 1 > (v.byteLength - a.byteOffset - element) / stride_)))
      bad(fmt::format("{} ({} elements) ends beyond its data", what, count_));
    at_ = bytes.data() + v.byteOffset + a.byteOffset;
  }
  std::size_t count() const { return count_; }
  bool is_float() const { return type_ == TINYGLTF_COMPONENT_TYPE_FLOAT; }
  double number(std::size_t element, int component) const {
    const unsigned char* p = at_ + element * stride_ + component * size_;
    switch (type_) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return scaled(std::max(-127.0, double(as<std::int8_t>(p))), 127);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return scaled(as<std::uint8_t>(p), 255);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return scaled(std::max(-32767.0, double(as<std::int16_t>(p))), 32767);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return scaled(as<std::uint16_t>(p), 65535);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return as<std::uint32_t>(p);
      default:
        return as<float>(p);
    }
  }
  Vec3 vector(std::size_t element) const {
    return {number(element, 0), number(element, 1), number(element, 2)};
  }

 private:
  template <class T>
  static T as(const unsigned char* p) {
    T out;
    std::memcpy(&out, p, sizeof out);
    return out;
  }
  double scaled(double v, double top) const { return normalized_ ? v / top : v; }

  const unsigned char* at_ = nullptr;
  std::size_t count_ = 0, stride_ = 0, size_ = 0;
  int type_ = 0, components_;
  bool normalized_ = false;
};

Eigen::Affine3d affine_of(const Vec3& translation, const Eigen::Quaterniond& rotation, const Vec3& scale) {
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  out.translate(translation).rotate(rotation).scale(scale);
  return out;
}

Eigen::Affine3d local_of(const tinygltf::Node& node, std::size_t number) {
  const auto given = [&](const std::vector<double>& v, std::size_t count, const char* what) {
    if (v.empty()) return false;
    if (v.size() != count)
      bad(fmt::format("node {}: {} has {} numbers instead of {}", number, what, v.size(), count));
    for (const double x : v)
      if (!std::isfinite(x)) bad(fmt::format("node {}: {} is not finite", number, what));
    return true;
  };
  if (given(node.matrix, 16, "matrix")) {
    Eigen::Affine3d out = Eigen::Affine3d::Identity();
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row) out.matrix()(row, column) = node.matrix[4 * column + row];
    return out;
  }
  Vec3 translation = Vec3::Zero(), scale = Vec3::Ones();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  if (given(node.translation, 3, "translation"))
    translation = Vec3(node.translation[0], node.translation[1], node.translation[2]);
  if (given(node.scale, 3, "scale")) scale = Vec3(node.scale[0], node.scale[1], node.scale[2]);
  if (given(node.rotation, 4, "rotation")) {
    rotation = Eigen::Quaterniond(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    if (!(rotation.norm() > 1e-6)) bad(fmt::format("node {}: rotation is zero", number));
    rotation.normalize();
  }
  return affine_of(translation, rotation, scale);
}

// The transforms of EXT_mesh_gpu_instancing relative to the node; one if the node has no instances.
std::vector<Eigen::Affine3d> instances_of_node(const tinygltf::Model& model, const tinygltf::Node& node,
                                               std::size_t number, std::uint64_t memory) {
  const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
  if (extension == node.extensions.end()) return {Eigen::Affine3d::Identity()};
  if (!extension->second.IsObject() || !extension->second.Has("attributes") ||
      !extension->second.Get("attributes").IsObject())
    bad(fmt::format("node {}: EXT_mesh_gpu_instancing has no attributes", number));
  const auto& attributes = extension->second.Get("attributes");
  std::optional<AccessorReader> translation, rotation, scale;
  std::optional<std::size_t> count;
  const auto take = [&](const char* name, int components, std::optional<AccessorReader>& out) {
    if (!attributes.Has(name)) return;
    const auto& index = attributes.Get(name);
    const std::string what = fmt::format("node {}: {} of the instances", number, name);
    if (!index.IsInt()) bad(what + " is not a number of an accessor");
    out.emplace(model, index.GetNumberAsInt(), what, components);
    if (count && *count != out->count()) bad(fmt::format("node {}: its instances differ in number", number));
    count = out->count();
  };
  take("TRANSLATION", 3, translation);
  take("ROTATION", 4, rotation);
  take("SCALE", 3, scale);
  if (!count) bad(fmt::format("node {}: its instances have no place", number));
  require_memory(double(*count) * sizeof(Eigen::Affine3d), memory, "the list of instances");
  std::vector<Eigen::Affine3d> out;
  for (std::size_t i = 0; i < *count; ++i) {
    Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
    if (rotation) {
      q = Eigen::Quaterniond(rotation->number(i, 3), rotation->number(i, 0), rotation->number(i, 1),
                             rotation->number(i, 2));
      if (!(q.norm() > 1e-6) || !q.coeffs().allFinite())
        bad(fmt::format("node {}: the rotation of instance {} is zero or not finite", number, i));
      q.normalize();
    }
    out.push_back(affine_of(translation ? translation->vector(i) : Vec3(Vec3::Zero()), q,
                            scale ? scale->vector(i) : Vec3(Vec3::Ones())));
  }
  return out;
}

// Triangles of one primitive as indices of its vertices.
std::vector<std::array<std::size_t, 3>> triangles_of_primitive(const tinygltf::Model& model,
                                                               const tinygltf::Primitive& primitive,
                                                               std::size_t vertices,
                                                               const std::string& what) {
  std::optional<AccessorReader> indices;
  if (primitive.indices >= 0) {
    indices.emplace(model, primitive.indices, what + ": its indices", 1);
    if (indices->is_float()) bad(what + ": its indices are not whole numbers");
  }
  const std::size_t count = indices ? indices->count() : vertices;
  const auto corner = [&](std::size_t i) {
    if (!indices) return i;
    const double v = indices->number(i, 0);
    if (!(v >= 0 && v < double(vertices)))
      bad(fmt::format("{} refers to vertex {} of {}", what, v, vertices));
    return static_cast<std::size_t>(v);
  };
  std::vector<std::array<std::size_t, 3>> out;
  if (primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode < 0) {
    if (count % 3 != 0) bad(fmt::format("{} has {} corners, which is not a multiple of 3", what, count));
    for (std::size_t i = 0; i + 2 < count; i += 3) out.push_back({corner(i), corner(i + 1), corner(i + 2)});
    return out;
  }
  for (std::size_t i = 0; i + 2 < count; ++i) {
    if (primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN)
      out.push_back({corner(0), corner(i + 1), corner(i + 2)});
    else if (i % 2 == 0)
      out.push_back({corner(i), corner(i + 1), corner(i + 2)});
    else
      out.push_back({corner(i + 1), corner(i), corner(i + 2)});
  }
  // Strips repeat corners in order to turn; such triangles have no area.
  std::erase_if(out, [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  return out;
}

class SceneReader {
 public:
  SceneReader(const tinygltf::Model& model, const Reading& reading, TextureCoordinates uv)
      : model_(model), reading_(reading), textured_(uv == TextureCoordinates::Read) {}

  PolygonSoup read() {
    seen_.assign(model_.nodes.size(), false);
    std::vector<std::pair<std::size_t, Eigen::Affine3d>> open;
    for (const int root : roots()) open.emplace_back(node_number(root), Eigen::Affine3d::Identity());
    while (!open.empty()) {
      const auto [number, above] = open.back();
      open.pop_back();
      if (seen_[number]) bad(fmt::format("node {} is reached twice", number));
      seen_[number] = true;
      const tinygltf::Node& node = model_.nodes[number];
      const Eigen::Affine3d here = above * local_of(node, number);
      if (node.mesh >= 0) {
        if (node.skin >= 0) skins_ = true;
        for (const Eigen::Affine3d& instance : instances_of_node(model_, node, number, reading_.memory))
          add_mesh(node.mesh, here * instance);
      }
      for (const int child : node.children) open.emplace_back(node_number(child), here);
    }
    if (skins_) reading_.warn("the file has bones, which are ignored: the mesh is in its rest position");
    if (skipped_) reading_.warn("points and lines in the file were left out");
    if (soup_.without_uv > 0) soup_.uv.clear();
    return std::move(soup_);
  }

 private:
  std::vector<int> roots() const {
    if (!model_.scenes.empty()) {
      const std::size_t scene = std::max(0, model_.defaultScene);
      if (scene >= model_.scenes.size())
        bad(fmt::format("its scene is number {} of {}", scene, model_.scenes.size()));
      return model_.scenes[scene].nodes;
    }
    std::vector<bool> child(model_.nodes.size(), false);
    for (const auto& node : model_.nodes)
      for (const int c : node.children) child[node_number(c)] = true;
    std::vector<int> out;
    for (std::size_t i = 0; i < child.size(); ++i)
      if (!child[i]) out.push_back(i);
    return out;
  }
  std::size_t node_number(int node) const {
    if (node < 0 || static_cast<std::size_t>(node) >= model_.nodes.size())
      bad(fmt::format("it refers to node {} of {}", node, model_.nodes.size()));
    return node;
  }

  void add_mesh(int mesh, const Eigen::Affine3d& place) {
    if (static_cast<std::size_t>(mesh) >= model_.meshes.size())
      bad(fmt::format("it refers to mesh {} of {}", mesh, model_.meshes.size()));
    const auto& primitives = model_.meshes[mesh].primitives;
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = primitives[p];
      if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
        bad(fmt::format("mesh {}, primitive {}: its mode is {}", mesh, p, primitive.mode));
      if (primitive.mode >= 0 && primitive.mode < TINYGLTF_MODE_TRIANGLES) {
        skipped_ = true;
        continue;
      }
      add_primitive(primitive, fmt::format("mesh {}, primitive {}", mesh, p), place);
    }
  }

  void add_primitive(const tinygltf::Primitive& primitive, const std::string& what,
                     const Eigen::Affine3d& place) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) bad(what + " has no positions");
    const AccessorReader points(model_, position->second, what + ": POSITION", 3);
    const auto triangles = triangles_of_primitive(model_, primitive, points.count(), what);
    // A mesh may be used by many nodes and instances.
    bytes_ += 24.0 * double(points.count()) + 180.0 * double(triangles.size());
    require_memory(bytes_, reading_.memory, "the meshes of the scene");
    const std::size_t first = soup_.vertices.size();
    if (first + points.count() > 0x7fffffff) unsupported("it has more than 2^31 vertices", "split it");
    for (std::size_t i = 0; i < points.count(); ++i) {
      const Vec3 v = points.vector(i);
      if (!v.allFinite()) bad(fmt::format("{}: vertex {} is not finite", what, i));
      const Vec3 m = place * v;
      // y up to z up
      soup_.vertices.push_back(kMillimeters * Vec3(m.x(), -m.z(), m.y()));
    }
    const bool mirrored = place.linear().determinant() < 0;
    std::vector<Eigen::Vector2f> uv;
    if (textured_) {
      uv = coordinates_of(primitive, points.count(), what);
      if (uv.empty()) soup_.without_uv += triangles.size();
    }
    for (auto t : triangles) {
      if (mirrored) std::swap(t[1], t[2]);
      std::vector<int> polygon;
      for (const std::size_t v : t) polygon.push_back(first + v);
      soup_.polygons.push_back(std::move(polygon));
      if (textured_ && soup_.without_uv == 0) soup_.uv.push_back({uv[t[0]], uv[t[1]], uv[t[2]]});
    }
  }

  // Of each vertex; empty if not all have finite ones.
  std::vector<Eigen::Vector2f> coordinates_of(const tinygltf::Primitive& primitive, std::size_t vertices,
                                              const std::string& what) const {
    const auto found = primitive.attributes.find("TEXCOORD_0");
    if (found == primitive.attributes.end()) return {};
    const AccessorReader given(model_, found->second, what + ": TEXCOORD_0", 2);
    if (given.count() != vertices) bad(what + " has another number of positions than of TEXCOORD_0");
    std::vector<Eigen::Vector2f> out;
    for (std::size_t i = 0; i < vertices; ++i) {
      out.emplace_back(static_cast<float>(given.number(i, 0)), static_cast<float>(given.number(i, 1)));
      if (!out.back().allFinite()) return {};
    }
    return out;
  }

  const tinygltf::Model& model_;
  const Reading& reading_;
  PolygonSoup soup_;
  std::vector<bool> seen_;
  double bytes_ = 0;
  bool skins_ = false, skipped_ = false, textured_;
};

}  // namespace

PolygonSoup read_gltf(std::string_view bytes, const Reading& reading, TextureCoordinates uv) {
  if (bytes.size() > 0xffffffffu) damaged("is larger than 4 GiB");
  const bool binary = bytes.starts_with("glTF");
  const std::string_view json = json_of_gltf(bytes, binary);
  check_depth(json);
  require_memory(kJsonBytes * double(json.size()) + 3 * double(bytes.size()), reading.memory, "the scene");
  const tinygltf::Model model = parsed(bytes, binary);
  for (const std::string& name : model.extensionsRequired)
    if (name != "EXT_mesh_gpu_instancing" && name != "KHR_mesh_quantization" &&
        name != "KHR_texture_transform" && name != "KHR_texture_basisu" && name != "EXT_texture_webp" &&
        !name.starts_with("KHR_materials_"))
      unsupported("it needs the glTF extension '" + printable(name) + "', which is not supported",
                  "export it without compression");
  return SceneReader(model, reading, uv).read();
}

}  // namespace terrazzo::load_mesh

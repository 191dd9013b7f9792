#include "nodes/export/formats/material_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/data/indices.h"
#include "nodes/export/formats/gltf_packer.h"
#include "nodes/export/formats/picture_file.h"

namespace terrazzo::exporting {
namespace {

void require_finite(const MapName& map, const Image& image) {
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    if (!image.pixels[i].allFinite())
      throw Error("bad-pixels", fmt::format("{} contains NaN or infinity at column {}, row {}", map.name,
                                            i % image.width, i / image.width));
}

// Values of the first `channels` channels, from 0 to `top`.
template <class T>
std::vector<T> rounded(const Image& image, int channels, float top) {
  std::vector<T> out;
  out.reserve(image.pixels.size() * channels);
  for (const Vec3f& p : image.pixels)
    for (int k = 0; k < channels; ++k)
      out.push_back(static_cast<T>(std::lround(std::clamp(p[k], 0.0f, 1.0f) * top)));
  return out;
}

std::vector<float> floats(const Image& image, int channels) {
  std::vector<float> out;
  out.reserve(image.pixels.size() * channels);
  for (const Vec3f& p : image.pixels) out.insert(out.end(), p.data(), p.data() + channels);
  return out;
}

bool is(const MapName& map, const Image* MaterialMaps::*image) { return map.image == image; }

void require_one_section(const char* name, const Image& image) {
  if (image.sections != 1)
    throw Error("format-does-not-fit",
                fmt::format("{} has {} sections, but a map has one", name, image.sections),
                "connect an image of one section");
}

std::string png_of(const Image& image, const std::vector<std::uint8_t>& bytes) {
  PictureEncoding encoding;
  encoding.width = image.width;
  encoding.height = image.height;
  encoding.attributes = {{"oiio:ColorSpace", "Raw"}};
  return encoded_png(encoding, bytes.data());
}

// Occlusion, roughness and metalness in one picture, as glTF reads them. Missing maps: open, and 0.6.
std::string packed_png(const MaterialMaps& maps) {
  std::vector<std::uint8_t> bytes;
  const auto byte = [&](const Image* map, std::size_t i, float otherwise) {
    return static_cast<std::uint8_t>(
        std::lround(255 * std::clamp(map ? map->pixels[i].x() : otherwise, 0.0f, 1.0f)));
  };
  for (std::size_t i = 0; i < maps.base_color->pixels.size(); ++i)
    bytes.insert(bytes.end(), {byte(maps.occlusion, i, 1), byte(maps.roughness, i, 0.6f), 0});
  return png_of(*maps.base_color, bytes);
}

// Two triangles that face up, with the picture's upper left corner at (0, 0).
Shape plane(double width, double height) {
  Shape s;
  s.name = "plane";
  s.mesh.vertices = {{-width / 2, -height / 2, 0},
                     {width / 2, -height / 2, 0},
                     {width / 2, height / 2, 0},
                     {-width / 2, height / 2, 0}};
  s.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  s.uv = {{Eigen::Vector2f(0, 1), Eigen::Vector2f(1, 1), Eigen::Vector2f(1, 0)},
          {Eigen::Vector2f(0, 1), Eigen::Vector2f(1, 0), Eigen::Vector2f(0, 0)}};
  return s;
}

// Of all connected maps, which are also finite.
void require_equal_sizes(const MaterialMaps& maps) {
  const MapName* first = nullptr;
  for (const MapName& map : kMaps) {
    const Image* image = maps.*map.image;
    if (!image) continue;
    require_one_section(map.name, *image);
    require_finite(map, *image);
    if (!first) first = &map;
    const Image& other = *(maps.*first->image);
    if (image->width != other.width || image->height != other.height)
      throw Error("size-mismatch",
                  fmt::format("{} has {} × {} pixels, but {} has {} × {}", map.name, image->width,
                              image->height, first->name, other.width, other.height),
                  "connect maps of the same node");
  }
}

// What a channel of a packed picture holds.
struct PackedChannel {
  const Image* image = nullptr;  // null: the constant
  int channel = 0;
  bool inverted = false;
  float constant = 0;

  float at(std::size_t i) const {
    const float v = image ? image->pixels[i][channel] : constant;
    return inverted ? 1 - v : v;
  }
};

PackedChannel packed_channel(const std::string& word, const MaterialMaps& maps, bool floats) {
  if (word == "black" || word == "white") return {nullptr, 0, false, word == "white" ? 1.0f : 0.0f};
  const auto bad = [&](const std::string& why) {
    return Error(
               "bad-value", fmt::format("'{}' in pack {}", word, why),
               "use normal, height, roughness, occlusion or id, with .g or .b for its other channels and 1- "
               "before it for one minus its value, or black or white")
        .parameter("pack");
  };
  PackedChannel out;
  std::string name = word;
  out.inverted = name.starts_with("1-");
  if (out.inverted) name.erase(0, 2);
  if (name.size() > 2 && name[name.size() - 2] == '.') {
    const auto channel = std::string("rgb").find(name.back());
    if (channel == std::string::npos) throw bad("is no channel");
    out.channel = static_cast<int>(channel);
    name.resize(name.size() - 2);
  }
  for (const MapName& map : kMaps) {
    if (name != map.name) continue;
    if (is(map, &MaterialMaps::base_color)) throw bad("is not raw, while packed channels are");
    if (is(map, &MaterialMaps::height) && !floats)
      throw Error("format-does-not-fit", "heights are in mm, but this format holds values up to 1",
                  "use .exr")
          .parameter("path");
    out.image = maps.*map.image;
    if (!out.image)
      throw Error("missing-input", fmt::format("pack names {}, which is not connected", name),
                  fmt::format("connect {}, or use black or white", name))
          .parameter("pack");
    return out;
  }
  throw bad("is no map");
}

}  // namespace

void write_map(const std::filesystem::path& path, const MapName& map, const Image& image,
               const std::string& provenance) {
  require_one_section(map.name, image);
  if (is(map, &MaterialMaps::base_color)) return write_picture(path, image, 0, provenance);
  require_finite(map, image);
  const std::string extension = path.extension().string();
  const bool color = is(map, &MaterialMaps::normal) || is(map, &MaterialMaps::id);
  const bool deep = is(map, &MaterialMaps::normal) || (extension == ".tif" && !color);
  PictureEncoding encoding;
  encoding.width = image.width;
  encoding.height = image.height;
  encoding.channels = color ? 3 : 1;
  encoding.attributes = {{"oiio:ColorSpace", "Raw"}};  // no gamma: these are numbers, not colors
  if (extension == ".exr") encoding.attributes.emplace_back("compression", "zip");
  if (!provenance.empty()) encoding.attributes.emplace_back("ImageDescription", provenance);
  if (extension == ".exr") {
    encoding.sample = Sample::Float;
    return write_samples(path, encoding, floats(image, encoding.channels).data());
  }
  if (is(map, &MaterialMaps::height))
    throw Error("format-does-not-fit", "heights are in mm, but a " + extension + " file holds values up to 1",
                "use .exr")
        .parameter("path");
  encoding.sample = deep ? Sample::UInt16 : Sample::UInt8;
  if (deep)
    return write_samples(path, encoding, rounded<std::uint16_t>(image, encoding.channels, 65535).data());
  write_samples(path, encoding, rounded<std::uint8_t>(image, encoding.channels, 255).data());
}

void write_packed_maps(const std::filesystem::path& path, const MaterialMaps& maps,
                       const std::vector<std::string>& channels, const std::string& provenance) {
  require_equal_sizes(maps);
  const bool floats = path.extension() == ".exr";
  std::vector<PackedChannel> from;
  const Image* any = nullptr;
  for (const std::string& word : channels) {
    from.push_back(packed_channel(word, maps, floats));
    if (from.back().image) any = from.back().image;
  }
  if (!any)
    throw Error("missing-input", "pack names no map", "name at least one of the connected maps")
        .parameter("pack");
  PictureEncoding encoding;
  encoding.width = any->width;
  encoding.height = any->height;
  encoding.channels = static_cast<int>(from.size());
  encoding.alpha = encoding.channels == 4 ? 3 : -1;
  encoding.attributes = {{"oiio:ColorSpace", "Raw"}};
  if (encoding.channels == 4) encoding.attributes.emplace_back("oiio:UnassociatedAlpha", 1);
  if (floats) encoding.attributes.emplace_back("compression", "zip");
  if (!provenance.empty()) encoding.attributes.emplace_back("ImageDescription", provenance);
  std::vector<float> values;
  values.reserve(any->pixels.size() * from.size());
  for (std::size_t i = 0; i < any->pixels.size(); ++i)
    for (const PackedChannel& channel : from) values.push_back(channel.at(i));
  if (floats) {
    encoding.sample = Sample::Float;
    return write_samples(path, encoding, values.data());
  }
  const bool deep = path.extension() == ".tif";
  encoding.sample = deep ? Sample::UInt16 : Sample::UInt8;
  std::vector<std::uint8_t> bytes;
  std::vector<std::uint16_t> words;
  for (const float v : values) {
    const float unit = std::clamp(v, 0.0f, 1.0f);
    if (deep)
      words.push_back(static_cast<std::uint16_t>(std::lround(unit * 65535)));
    else
      bytes.push_back(static_cast<std::uint8_t>(std::lround(unit * 255)));
  }
  if (deep) return write_samples(path, encoding, words.data());
  write_samples(path, encoding, bytes.data());
}

void write_glb(const std::filesystem::path& path, const MaterialMaps& maps, const std::string& provenance,
               const Shape* mesh) {
  if (!maps.base_color)
    throw Error("missing-input", "a material needs the map base_color, which is not connected",
                "connect base_color of TextureSet or Bake");
  require_equal_sizes(maps);
  if (mesh && mesh->uv.empty())
    throw Error("no-uv", "the shape '" + mesh->name + "' has no texture coordinates, so no map fits it",
                "connect Bake.mesh");
  const Image& base = *maps.base_color;
  GltfPacker pack;
  const int material = pack.textured_material("material", base);
  tinygltf::Material& m = pack.model.materials[material];
  m.pbrMetallicRoughness.roughnessFactor = 1;
  m.pbrMetallicRoughness.metallicFactor = 1;
  const int packed = pack.texture("occlusion_roughness_metallic", packed_png(maps));
  m.pbrMetallicRoughness.metallicRoughnessTexture.index = packed;
  if (maps.occlusion) m.occlusionTexture.index = packed;
  if (maps.normal)
    m.normalTexture.index = pack.texture("normal", png_of(base, rounded<std::uint8_t>(*maps.normal, 3, 255)));
  const Shape shape = mesh ? *mesh : plane(base.width * base.pixel_size, base.height * base.pixel_size);
  tinygltf::Primitive primitive = pack.primitive(shape, true);
  if (!mesh) {  // readers derive the tangents of a mesh from its texture coordinates, as glTF prescribes
    std::vector<float> tangents;
    for (int corner = 0; corner < 6; ++corner) tangents.insert(tangents.end(), {1, 0, 0, 1});
    primitive.attributes["TANGENT"] = pack.floats(tangents, 4, TINYGLTF_TARGET_ARRAY_BUFFER);
  }
  primitive.material = material;
  tinygltf::Node node;
  node.name = "material";
  node.mesh = pack.mesh(shape.name, primitive);
  pack.root(pack.node(std::move(node)));
  pack.write(path, provenance);
}

}  // namespace terrazzo::exporting

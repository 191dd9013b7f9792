#include "nodes/export/formats/materialx_file.h"

#include <fmt/format.h>

#include "nodes/common/io/checked_file.h"
#include "runtime/files/base64.h"

namespace terrazzo::exporting {
namespace {

// A map of the graph "maps": the picture, and for normals the node that decodes it.
std::string map_node(const std::string& name, const std::string& type, const std::string& file,
                     const std::string& more = "") {
  return fmt::format(
      "    <tiledimage name=\"{0}_image\" type=\"{1}\">\n"
      "      <input name=\"file\" type=\"filename\" value=\"{2}\"{3}/>\n"
      "    </tiledimage>\n",
      name, type, file, more);
}

std::string output(const std::string& name, const std::string& type, const std::string& node) {
  return fmt::format("    <output name=\"{}\" type=\"{}\" nodename=\"{}\"/>\n", name, type, node);
}

std::string input(const std::string& name, const std::string& type, const std::string& output) {
  return fmt::format("    <input name=\"{}\" type=\"{}\" nodegraph=\"maps\" output=\"{}\"/>\n", name, type,
                     output);
}

}  // namespace

void write_materialx(const std::filesystem::path& path, const MaterialMaps& maps, SurfaceShader shader,
                     const std::string& provenance) {
  if (!maps.base_color)
    throw Error("missing-input", "a material needs the map base_color, which is not connected",
                "connect TextureSet.base_color");
  const bool open_pbr = shader == SurfaceShader::OpenPbr;
  const char* node = open_pbr ? "open_pbr_surface" : "standard_surface";
  std::string graph = map_node("base_color", "color3", "base_color.png", " colorspace=\"srgb_texture\"");
  std::string outputs = output("base_color", "color3", "base_color_image");
  std::string inputs = input("base_color", "color3", "base_color");
  if (maps.roughness) {
    graph += map_node("roughness", "float", "roughness.png");
    outputs += output("roughness", "float", "roughness_image");
    inputs += input("specular_roughness", "float", "roughness");
  }
  if (maps.normal) {
    graph += map_node("normal", "vector3", "normal.png");
    graph +=
        "    <normalmap name=\"normal_map\" type=\"vector3\">\n"
        "      <input name=\"in\" type=\"vector3\" nodename=\"normal_image\"/>\n"
        "    </normalmap>\n";
    outputs += output("normal", "vector3", "normal_map");
    inputs += input(open_pbr ? "geometry_normal" : "normal", "vector3", "normal");
  }
  CheckedFile file(path);
  file.guard([&](std::ostream& out) {
    out << "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n";
    if (!provenance.empty()) out << "<!-- provenance " << encode_base64(provenance) << " -->\n";
    out << fmt::format(
        "<materialx version=\"{0}\" colorspace=\"lin_rec709\">\n"
        "  <nodegraph name=\"maps\">\n{1}{2}  </nodegraph>\n"
        "  <{3} name=\"surface\" type=\"surfaceshader\">\n"
        "    <input name=\"{4}\" type=\"float\" value=\"1\"/>\n{5}  </{3}>\n"
        "  <surfacematerial name=\"terrazzo\" type=\"material\">\n"
        "    <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"surface\"/>\n"
        "  </surfacematerial>\n"
        "</materialx>\n",
        open_pbr ? "1.39" : "1.38", graph, outputs, node, open_pbr ? "base_weight" : "base", inputs);
  });
}

}  // namespace terrazzo::exporting

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "graph/node_type.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/export/formats.h"
#include "nodes/export/formats/csv.h"
#include "nodes/export/formats/gltf.h"
#include "nodes/export/formats/mesh_file.h"
#include "nodes/export/formats/nifti_file.h"
#include "nodes/export/formats/npy_file.h"
#include "nodes/export/formats/nvdb_file.h"
#include "nodes/export/formats/picture_file.h"
#include "nodes/export/formats/shapes_json.h"
#include "nodes/export/formats/vdb_file.h"
#include "nodes/export/outputs.h"
#include "runtime/context.h"
#include "runtime/json_text.h"

namespace terrazzo::exporting {
namespace {

// The inputs, named after their types.
struct Input {
  const char *name, *type, *doc;
};
constexpr std::array<Input, 10> inputs = {{
    {"image", "Image", "Image or stack of images. In a .glb file, the texture of the shapes"},
    {"labels", "Labels", "Profile id of each pixel"},
    {"profiles", "Profiles", "Profiles of plane sections"},
    {"shapes", "Shapes", "Shapes of the particles"},
    {"kmatrix", "KMatrix", "K matrix, the probabilities of profile sizes"},
    {"distribution", "SizeDistribution", "Number of particles per volume by size"},
    {"particles", "Particles",
     "Packing. A .glb, .usda, .xml or .pbrt file also needs shapes. A .vti or .inp file takes classes and "
     "voids from it"},
    {"volume", "Volume", "Volume of named grids"},
    {"table", "Table", "Table of named columns"},
    {"strokes", "Strokes", "Strokes on an image"},
}};

// The connected values, by type name.
std::map<std::string, Value> connected(const Context& c) {
  std::map<std::string, Value> values;
  for (const Input& in : inputs)
    if (c.has(in.name)) values[in.type] = c.value(in.name);
  if (c.has("value")) {
    const Value& v = c.value("value");
    if (!values.emplace(v.type().name, v).second)
      throw Error("two-inputs", "both 'value' and another input have type " + v.type().name,
                  "connect only one of them");
  }
  if (values.empty()) throw Error("no-input", "nothing is connected", "connect the value to write");
  return values;
}

std::string csv_of_value(const Value& v) {
  if (v.is<Table>()) return csv_of(v.as<Table>());
  if (v.is<Profiles>()) return csv_of(v.as<Profiles>());
  if (v.is<Particles>()) return csv_of(v.as<Particles>());
  if (v.is<SizeDistribution>()) return csv_of(v.as<SizeDistribution>());
  if (v.is<KMatrix>()) return csv_of(v.as<KMatrix>());
  return csv_of(v.as<Shapes>());
}

std::string json_text_of(const std::map<std::string, Value>& values) {
  const auto describe = [](const Value& v) {
    return v.is<Shapes>() ? json_with_meshes(v.as<Shapes>()) : v.type().describe(v.data());
  };
  if (values.size() == 1) return json_text(describe(values.begin()->second), 2) + "\n";
  nlohmann::json all = nlohmann::json::object();
  for (const auto& [type, v] : values) {
    std::string key = type;
    for (const Input& in : inputs)
      if (type == in.type) key = in.name;
    all[key] = describe(v);
  }
  return json_text(all, 2) + "\n";
}

// Writes one file per section.
template <class Picture, class Write>
void write_sections(Context& c, const std::string& path, const Picture& picture, Write&& write) {
  const std::string made_by = c.provenance();
  if (picture.sections < 1) throw Error("empty-image", "the image has no sections");
  for (int s = 0; s < picture.sections; ++s) {
    c.work().check();
    c.work().progress(double(s) / picture.sections);
    write_named(c, picture.sections == 1 ? path : section_name(path, s, picture.sections),
                [&](const std::filesystem::path& file) { write(file, picture, s, made_by); });
  }
}

// The grids for a .nvdb file. Those that it has no type for are left out, unless they were named.
Volume grids_for_nvdb(Context& c, const Volume& volume) {
  if (c.keyword("grids").empty()) return chosen_grids(c, volume);
  std::vector<std::string> lost;
  Volume out = fit_for_nvdb(volume, lost);
  for (const std::string& name : lost)
    c.warn(fmt::format("the grid '{}' is left out: a .nvdb file has no type for it", name));
  return out;
}

void compute(Context& c) {
  const std::string path = c.text("path");
  const Format& format = format_of(path);
  const auto values = connected(c);
  check_fit(format, values);
  const std::string extension = format.extension;
  const Value& first = values.begin()->second;
  const auto volume = [&] { return values.count("Volume") ? &values.at("Volume").as<Volume>() : nullptr; };
  const auto particles = [&] {
    return values.count("Particles") ? &values.at("Particles").as<Particles>() : nullptr;
  };
  if (extension == ".vti") return export_vti(c, path, *volume(), particles());
  if (extension == ".dream3d") return export_dream3d(c, path, *volume(), particles());
  if (extension == ".inp") return export_inp(c, path, format, *volume(), particles());
  if (extension == ".msh" || (extension == ".stl" && !values.count("Shapes"))) {
    if (!volume())
      throw Error("missing-input", "particles without their shapes and volume have no surface",
                  "connect Voxelize.volume, or shapes");
    return export_surfaces(c, path, format, *volume(), particles());
  }
  if (extension == ".stl" && values.size() > 1)
    throw Error("format-does-not-fit", "a .stl file holds one shape, or the surface of a volume, not both",
                "use one Export node for each")
        .parameter("path");
  if (extension == ".usda" || extension == ".xml" || extension == ".pbrt")
    return export_scene(c, path, format, particles(), values.at("Shapes").as<Shapes>(), volume());
  if (first.is<Image>() && extension != ".json" && extension != ".glb")
    return write_sections(c, path, first.as<Image>(), write_picture);
  if (first.is<Labels>() && extension != ".json" && extension != ".npy")
    return write_sections(c, path, first.as<Labels>(), write_labels);
  write_named(c, path, [&](const std::filesystem::path& file) {
    if (extension == ".glb") {
      const Shapes& shapes = values.at("Shapes").as<Shapes>();
      const Image* texture = values.count("Image") ? &values.at("Image").as<Image>() : nullptr;
      if (particles() && texture)
        throw Error("no-uv", "an image is the texture of shapes without particles; both are connected",
                    "disconnect the image or the particles");
      if (particles())
        write_glb(file, *particles(), shapes, c.provenance(), c.work(), c.choice<Instancing>("instancing"),
                  static_cast<int>(c.integer("materials")));
      else
        write_glb(file, shapes, c.provenance(), c.work(), texture);
    } else if (extension == ".vdb") {
      write_vdb(file, chosen_grids(c, first.as<Volume>()), c.provenance(), c.choice<WholeNumbers>("id_type"));
    } else if (extension == ".nvdb") {
      write_nvdb(file, grids_for_nvdb(c, first.as<Volume>()), c.work());
    } else if (extension == ".npy" && first.is<Labels>()) {
      write_npy(file, first.as<Labels>());
    } else if (extension == ".npy" || extension == ".nii" || extension == ".nii.gz") {
      const VoxelBox box = voxel_box(first.as<Volume>());
      const VoxelSource grid = only_grid(c, first.as<Volume>(), box);
      if (extension == ".npy")
        write_npy(file, grid, box, c.work());
      else
        write_nifti(file, grid, box, c.provenance(), c.work());
    } else if (extension == ".csv") {
      write_bytes(file, csv_of_value(first));
    } else if (extension == ".json") {
      write_bytes(file, json_text_of(values));
    } else {
      write_mesh(file, first.as<Shapes>());
    }
  });
}

}  // namespace
}  // namespace terrazzo::exporting

namespace terrazzo {

NodeType export_node() {
  using namespace exporting;
  NodeType type("Export", 6);
  type.doc_(
          "Writes the connected values to a file below the output folder. The extension selects the format.")
      .source_(
          "glTF 2.0 with EXT_mesh_gpu_instancing; OpenUSD; OpenVDB; VTK XML 1.0; DREAM3D file version 7.0; "
          "NIfTI-1; "
          "Abaqus keywords; Gmsh MSH 2.2; NanoVDB 32; Mitsuba 3; pbrt-v4; OpenImageIO; RFC 4180");
  for (const Input& in : inputs) type.optional_input(in.name, {in.type}, in.doc);
  return type.optional_input("value", {}, "Value of any of these types, instead of the input of that type")
      .parameter(Parameter::output_path("path").doc_(
          "File to write: .glb (particles with shapes, or shapes, with colors or a texture if they have "
          "them), .usda (particles with shapes, or shapes, and a volume as .vdb beside it), .xml, .pbrt "
          "(scenes for Mitsuba 3 and pbrt-v4: particles with shapes, and a volume as the medium of the "
          "binder), .vdb, .nvdb (volume), .vti (volume), .dream3d (volume), .inp (volume as a mesh of "
          "voxels), .msh, .stl (surfaces of a volume's particles, cut at the sides of the box), .npy (one "
          "grid of a volume, or labels), .nii, .nii.gz (one grid of a volume), .png, .jpg, .tif, .exr, .hdr "
          "(images; a stack becomes name_000, name_001, …), .png, .tif, .exr (labels, as exact ids), .csv "
          "(tables, profiles, particles, distributions, K matrices, shapes), .json (any type), .obj, .ply, "
          ".stl (shapes)."))
      .parameter(
          Parameter::choice("instancing", "extension", {"extension", "nodes"})
              .doc_(".glb: extension: one node per shape with EXT_mesh_gpu_instancing, compact. nodes: "
                    "one node per particle, for programs without the extension, such as Blender, Godot "
                    "and Unreal."))
      .parameter(
          Parameter::integer("materials", 64)
              .range(1, 65535)
              .doc_(".glb with instancing: nodes, .xml, .pbrt: most materials. More colors than that are "
                    "rounded to this many; the extras of each node of a .glb file have the exact color."))
      .parameter(
          Parameter::choice("id_type", "float", {"float", "int32"})
              .doc_(".vdb: type of the grids of whole numbers (id, source). float: more programs read it; "
                    "exact up to 2^24. int32: unchanged. LoadVolume gives the same grids for both."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Texts, "grids", "auto")
              .count(1, 64)
              .doc_(".vdb, .nvdb, .vti, .dream3d, .usda: names of the grids to write. .npy, .nii: name of "
                    "the one grid. "
                    "auto: all; for .npy and .nii, id or the only grid."))
      .parameter(
          Parameter::choice("regions", "particles", {"particles", "phases"})
              .doc_(
                  ".vti, .dream3d, .inp, .msh: what has a number, element set or surface of its own, besides "
                  "the binder: every particle, or every class of particles and all voids together (needs "
                  "particles)."))
      .parameter(
          Parameter::integer("smoothing", 10)
              .range(0, 1000)
              .doc_(
                  ".msh and .stl of a volume: how often each node moves toward the mean of its neighbors on "
                  "the same surface, by at most half a voxel in all. 0: faces of voxels."))
      .parameter(Parameter::choice("compression", "zlib", {"zlib", "none"})
                     .doc_(".vti, .dream3d: compression of the voxels."))
      .writes_files_()
      .compute_(compute);
}

}  // namespace terrazzo

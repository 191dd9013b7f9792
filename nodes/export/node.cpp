#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "graph/node_type.h"
#include "nodes/common/io/checked_file.h"
#include "nodes/export/csv.h"
#include "nodes/export/dream3d_file.h"
#include "nodes/export/formats.h"
#include "nodes/export/gltf.h"
#include "nodes/export/inp_file.h"
#include "nodes/export/instances.h"
#include "nodes/export/mesh_file.h"
#include "nodes/export/nifti_file.h"
#include "nodes/export/npy_file.h"
#include "nodes/export/picture_file.h"
#include "nodes/export/surface_file.h"
#include "nodes/export/usda_file.h"
#include "nodes/export/vdb_file.h"
#include "nodes/export/vti_file.h"
#include "runtime/context.h"
#include "runtime/json_text.h"

namespace terrazzo {
namespace {
using namespace exporting;

// The inputs, named after their types.
struct Input {
  const char *name, *type, *doc;
};
constexpr std::array<Input, 9> inputs = {{
    {"image", "Image", "Image or stack of images. In a .glb file, the texture of the shapes"},
    {"labels", "Labels", "Profile id of each pixel"},
    {"profiles", "Profiles", "Profiles of plane sections"},
    {"shapes", "Shapes", "Shapes of the particles"},
    {"kmatrix", "KMatrix", "K matrix, the probabilities of profile sizes"},
    {"distribution", "SizeDistribution", "Number of particles per volume by size"},
    {"particles", "Particles",
     "Packing. A .glb or .usda file also needs shapes. A .vti or .inp file takes classes and voids from it"},
    {"volume", "Volume", "Volume of named grids"},
    {"table", "Table", "Table of named columns"},
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

std::string json_of(const std::map<std::string, Value>& values) {
  const auto describe = [](const Value& v) { return v.type().describe(v.data()); };
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

// Writers know only the temporary name. Errors of the disk are reported with the path that the user gave.
void write_named(Context& c, const std::string& path,
                 const std::function<void(const std::filesystem::path&)>& write) {
  c.write_file(path, [&](const std::filesystem::path& file) {
    try {
      write(file);
    } catch (const Error& e) {
      const Diagnostic& d = e.diagnostic();
      if (d.code != "write-failed" && d.code != "unwritable-image") throw;
      std::string why = d.message;
      if (const auto at = why.find("': "); at != std::string::npos) why = why.substr(at + 3);
      throw Error("write-failed", "cannot write '" + path + "': " + why, d.hint).parameter("path");
    }
  });
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

// The volume with the grids that the parameter `grids` names, or all.
Volume chosen_grids(const Context& c, const Volume& volume) {
  if (!c.keyword("grids").empty()) return volume;
  Volume out;
  out.resolution = volume.resolution;
  const auto all = grid_names(volume);
  for (const std::string& name : c.texts("grids")) {
    const auto at = std::find(all.begin(), all.end(), name);
    if (at == all.end())
      throw Error("no-such-grid",
                  fmt::format("the volume has no grid '{}' (its grids: {})", name, fmt::join(all, ", ")),
                  "choose one of them")
          .parameter("grids");
    out.grids.push_back(volume.grids[static_cast<std::size_t>(at - all.begin())]);
  }
  return out;
}

// The one grid of a file that holds only one.
VoxelSource only_grid(const Context& c, const Volume& volume, const VoxelBox& box) {
  const auto all = grid_names(volume);
  std::vector<std::string> names =
      c.keyword("grids").empty() ? grid_names(chosen_grids(c, volume)) : std::vector<std::string>();
  if (names.empty() && std::find(all.begin(), all.end(), "id") != all.end()) names = {"id"};
  if (names.empty() && all.size() == 1) names = all;
  if (names.size() != 1)
    throw Error("several-grids",
                fmt::format("the file holds one grid; the volume has {}", fmt::join(all, ", ")),
                "name one of them with grids")
        .parameter("grids");
  return {volume, names[0], box};
}

// Named after the whole file name: block.vti and block.inp each have their own numbers.
void write_region_table(Context& c, const std::string& path, const Regions& regions, const VoxelBox& box,
                        const Particles* particles) {
  write_named(c, path + ".csv", [&](const std::filesystem::path& file) {
    write_bytes(file, csv_of(region_table(regions, box, particles)));
  });
}

// The grid id of a volume and its regions, to which the content of a file of voxels refers.
struct Identified {
  std::optional<VoxelSource> id;  // none if the volume has no such grid of whole numbers
  Regions regions;
};

// Fills in the parts that files of voxels share. `content` refers to the result. `lost`: what the file lacks
// without regions.
template <class Content>
std::unique_ptr<Identified> fill_content(Context& c, Content& content, const Volume& volume,
                                         const Particles* particles, const std::string& lost) {
  content.box = voxel_box(volume);
  content.provenance = c.provenance();
  for (const std::string& name : grid_names(chosen_grids(c, volume)))
    content.grids.emplace_back(volume, name, content.box);
  auto out = std::make_unique<Identified>();
  const auto all = grid_names(volume);
  if (std::find(all.begin(), all.end(), "id") != all.end()) out->id.emplace(volume, "id", content.box);
  if (out->id && !out->id->whole()) {
    c.warn("the grid id does not contain whole numbers, so the file has no " + lost);
    out->id.reset();
  }
  if (out->id) {
    out->regions = find_regions(*out->id, content.box, particles, c.choice<RegionKind>("regions"),
                                c.work().part(0, 0.2));
    content.id = &*out->id, content.regions = &out->regions;
  }
  return out;
}

void export_vti(Context& c, const std::string& path, const Volume& volume, const Particles* particles) {
  VtiContent content;
  content.compression = c.choice<VtiCompression>("compression");
  const auto found = fill_content(c, content, volume, particles, "array material");
  write_named(c, path,
              [&](const std::filesystem::path& file) { write_vti(file, content, c.work().part(0.2, 1)); });
  if (found->id) write_region_table(c, path, found->regions, content.box, particles);
}

void export_dream3d(Context& c, const std::string& path, const Volume& volume, const Particles* particles) {
  Dream3dContent content;
  content.particles = particles;
  const auto found = fill_content(c, content, volume, particles, "features");
  write_named(c, path, [&](const std::filesystem::path& file) {
    write_dream3d(file, content, c.work().part(0.2, 1));
  });
}

void export_inp(Context& c, const std::string& path, const Format& format, const Volume& volume,
                const Particles* particles) {
  const VoxelBox box = voxel_box(volume);
  check_inp(box);
  const auto all = grid_names(volume);
  if (std::find(all.begin(), all.end(), "id") == all.end())
    throw Error("no-id", "the volume has no grid id, which tells materials apart", "connect Voxelize.volume");
  const VoxelSource id(volume, "id", box);
  const Regions regions =
      find_regions(id, box, particles, c.choice<RegionKind>("regions"), c.work().part(0, 0.1));
  write_named(c, path, [&](const std::filesystem::path& file) {
    write_inp(file, id, box, regions, c.memory(), c.provenance(), c.work().part(0.1, 0.9));
  });
  if (box.periodic)
    write_named(c, beside(path, format, "_periodic.inp"), [&](const std::filesystem::path& file) {
      write_periodic_inp(file, box, c.work().part(0.9, 1));
    });
  write_region_table(c, path, regions, box, particles);
}

// Surfaces of the regions of a volume.
void export_surfaces(Context& c, const std::string& path, const Format& format, const Volume& volume,
                     const Particles* particles) {
  const VoxelBox box = voxel_box(volume);
  const auto all = grid_names(volume);
  if (std::find(all.begin(), all.end(), "id") == all.end())
    throw Error("no-id", "the volume has no grid id, which tells particles apart", "connect Voxelize.volume");
  const VoxelSource id(volume, "id", box);
  const Regions regions =
      find_regions(id, box, particles, c.choice<RegionKind>("regions"), c.work().part(0, 0.1));
  const SurfaceNet net = surface_net(id, box, regions, static_cast<int>(c.integer("smoothing")), c.memory(),
                                     c.work().part(0.1, 0.6));
  c.metric("nodes", static_cast<double>(net.nodes.size()));
  c.metric("triangles", static_cast<double>(net.corners.size()));
  write_named(c, path, [&](const std::filesystem::path& file) {
    (format.extension == ".msh" ? write_msh : write_surface_stl)(file, net, regions, c.work().part(0.6, 1));
  });
  if (format.extension != ".msh") return;
  write_named(c, beside(path, format, ".geo"), [&](const std::filesystem::path& file) {
    write_geo(file, std::filesystem::path(path).filename().string(), net, regions);
  });
  write_region_table(c, path, regions, box, particles);
}

void export_usda(Context& c, const std::string& path, const Format& format, const Particles* particles,
                 const Shapes& shapes, const Volume* volume) {
  if (particles) instances_of(*particles, shapes);  // throws before the first of two files is written
  UsdaVolume beside_it;
  Volume chosen;
  if (volume) {
    chosen = chosen_grids(c, *volume);
    const std::string vdb = beside(path, format, ".vdb");
    beside_it = {std::filesystem::path(vdb).filename().string(), &chosen};
    if (beside_it.file.find('@') != std::string::npos)
      throw Error("bad-names", "the file name contains @, which encloses names in a .usda file", "rename it")
          .parameter("path");
    write_named(c, vdb, [&](const std::filesystem::path& file) {
      write_vdb(file, chosen, c.provenance(), c.choice<WholeNumbers>("id_type"));
    });
  }
  write_named(c, path, [&](const std::filesystem::path& file) {
    if (particles)
      write_usda(file, *particles, shapes, beside_it, c.provenance(), c.work());
    else
      write_usda(file, shapes, beside_it, c.provenance(), c.work());
  });
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
  if (extension == ".usda")
    return export_usda(c, path, format, particles(), values.at("Shapes").as<Shapes>(), volume());
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
      write_bytes(file, json_of(values));
    } else {
      write_mesh(file, first.as<Shapes>());
    }
  });
}

}  // namespace

NodeType export_node() {
  NodeType type("Export", 3);
  type.doc_(
          "Writes the connected values to a file below the output folder. The extension selects the format.")
      .source_(
          "glTF 2.0 with EXT_mesh_gpu_instancing; OpenUSD; OpenVDB; VTK XML 1.0; DREAM3D file version 7.0; "
          "NIfTI-1; "
          "Abaqus keywords; Gmsh MSH 2.2; "
          "OpenImageIO; RFC 4180");
  for (const Input& in : inputs) type.optional_input(in.name, {in.type}, in.doc);
  return type.optional_input("value", {}, "Value of any of these types, instead of the input of that type")
      .parameter(Parameter::output_path("path").doc_(
          "File to write: .glb (particles with shapes, or shapes, with colors or a texture if they have "
          "them), "
          ".usda (particles with shapes, or shapes, and a volume as .vdb beside it), .vdb (volume), .vti "
          "(volume), .dream3d (volume), .inp (volume as a mesh of "
          "voxels), "
          ".msh, .stl (surfaces of a volume's particles, cut at the sides of the box), .npy (one grid "
          "of a "
          "volume, or labels), .nii, .nii.gz (one grid of a volume), .png, .jpg, .tif, .exr, .hdr (images; a "
          "stack becomes name_000, name_001, …), .png, .tif, .exr (labels, as exact ids), .csv (tables, "
          "profiles, particles, distributions, K matrices, shapes), .json (any type), .obj, .ply, .stl "
          "(shapes)."))
      .parameter(
          Parameter::choice("instancing", "extension", {"extension", "nodes"})
              .doc_(".glb: extension: one node per shape with EXT_mesh_gpu_instancing, compact. nodes: "
                    "one node per particle, for programs without the extension, such as Blender, Godot "
                    "and Unreal."))
      .parameter(
          Parameter::integer("materials", 64)
              .range(1, 65535)
              .doc_(".glb with instancing: nodes: most materials. More colors than that are rounded to "
                    "this many; the extras of each node have the exact color."))
      .parameter(
          Parameter::choice("id_type", "float", {"float", "int32"})
              .doc_(".vdb: type of the grids of whole numbers (id, source). float: more programs read it; "
                    "exact up to 2^24. int32: unchanged. LoadVolume gives the same grids for both."))
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "grids", "auto")
                     .count(1, 64)
                     .doc_(".vdb, .vti, .dream3d, .usda: names of the grids to write. .npy, .nii: name of "
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
      .parameter(
          Parameter::choice("compression", "zlib", {"zlib", "none"}).doc_(".vti: compression of the voxels."))
      .writes_files_()
      .compute_(compute);
}

}  // namespace terrazzo

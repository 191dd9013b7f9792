#include "graph/node_type.h"
#include "nodes/export/formats.h"
#include "nodes/export/writers.h"
#include "runtime/context.h"

namespace terrazzo::exporting {
namespace {

// The connected values, by type name.
std::map<std::string, Value> connected(const Context& c) {
  std::map<std::string, Value> values;
  for (const Input& in : kInputs)
    if (c.has(in.name)) values[in.type] = c.value(in.name);
  for (const MapName& map : kMaps)
    if (c.has(map.name)) values[map.name] = c.value(map.name);
  if (c.has("value")) {
    const Value& v = c.value("value");
    if (!values.emplace(v.type().name, v).second)
      throw Error("two-inputs", "both 'value' and another input have type " + v.type().name,
                  "connect only one of them");
  }
  if (values.empty()) throw Error("no-input", "nothing is connected", "connect the value to write");
  return values;
}

// The format, which holds several maps if they are to be packed. Throws Error "format-does-not-fit".
Format chosen_format(const Context& c) {
  Format format = format_of(c.text("path"));
  if (!c.keyword("pack").empty()) return format;
  const std::string& end = format.extension;
  format.types.clear();
  for (const MapName& map : kMaps) format.types.push_back(map.name);
  format.several = true;
  if (end != ".png" && end != ".tif" && end != ".exr")
    throw Error("format-does-not-fit", "pack makes a .png, .tif or .exr picture, not a " + end + " file",
                "change the extension, or remove pack")
        .parameter("pack");
  return format;
}

void compute(Context& c) {
  const Format format = chosen_format(c);
  const Job job{c, c.text("path"), format, connected(c)};
  check_fit(format, job.values);
  format.write(job);
}

}  // namespace
}  // namespace terrazzo::exporting

namespace terrazzo {

NodeType export_node() {
  using namespace exporting;
  NodeType type("Export", 12);
  type.doc_(
          "Writes the connected values to a file below the output folder. The extension selects the format.")
      .source_(
          "glTF 2.0 with EXT_mesh_gpu_instancing; MaterialX 1.38 and 1.39; OpenUSD; OpenVDB; VTK XML 1.0; "
          "DREAM3D file version 7.0; "
          "NIfTI-1; "
          "Abaqus keywords; DAMASK 3; Neper tesr 2.1; OpenFOAM; LAMMPS; Gmsh MSH 2.2; NanoVDB 32; Mitsuba 3; "
          "pbrt-v4; OpenImageIO; DDS with header DX10; KTX 2.0; RFC 4180");
  for (const Input& in : kInputs) type.optional_input(in.name, {in.type}, in.doc);
  for (const MapName& map : kMaps) type.optional_input(map.name, {"Image"}, map.doc);
  return type.optional_input("value", {}, "Value of any of these types, instead of the input of that type")
      .parameter(Parameter::output_path("path").doc_(
          "File to write: .glb (particles with shapes, or shapes, with colors or a texture if they have "
          "them, or texture maps on a plane or a shape), .mtlx (texture maps, which are written beside it), "
          ".usda "
          "(particles with shapes, or shapes, and a volume as .vdb beside it), .xml, .pbrt "
          "(scenes for Mitsuba 3 and pbrt-v4: particles with shapes, and a volume as the medium of the "
          "binder), .vdb, .nvdb (volume), .vti, .dream3d, .vtu (volume), .inp (volume as a mesh of "
          "voxels), .tesr (volume, for Neper), .foam (case for OpenFOAM: the binder of a volume), .lmp "
          "(particles as spheres, for LAMMPS and LIGGGHTS), .msh, .stl (surfaces of a volume's particles, "
          "cut at the sides of the box), .npy (one "
          "grid of a volume, or labels), .nii, .nii.gz (one grid of a volume), .png, .jpg, .tif, .exr, .hdr "
          "(images; a stack becomes name_000, name_001, …; .png, .tif, .exr: also one texture map), .dds, "
          ".ktx2, "
          ".png (one grid of a volume as a 3D texture or, in .png, as its slices in rows), .png, .tif, .exr "
          "(labels, as exact ids), .csv "
          "(tables, profiles, particles, distributions, K matrices, shapes), .geojson, .coco.json, .roi, "
          ".zip (outlines of labels or profiles: GeoJSON, COCO, ImageJ; profiles need image or labels beside "
          "them), .json (any type), .obj, .ply, "
          ".stl (shapes, or particles with shapes)."))
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
          Parameter::choice("crossing", "once", {"once", "repeated", "cut"})
              .doc_(".glb, .usda, .xml, .pbrt, .obj, .ply, .stl: particles that reach out of the periodic "
                    "box. once: whole, so that copies of the box join. repeated: also at opposite sides, "
                    "wherever a part is in the box. cut: cut at the sides into closed meshes, which copies "
                    "of the box continue."))
      .parameter(
          Parameter::choice("id_type", "float", {"float", "int32"})
              .doc_(".vdb: type of the grids of whole numbers (id, source). float: more programs read it; "
                    "exact up to 2^24. int32: unchanged. LoadVolume gives the same grids for both."))
      .parameter(Parameter::with_keyword(ParameterKind::Texts, "grids", "auto")
                     .count(1, 64)
                     .doc_(".vdb, .nvdb, .vti, .vtu, .dream3d, .usda: names of the grids to write. .npy, "
                           ".nii: name of the one grid. .dds, .ktx2, .png: the grid, and for alpha one of "
                           "single numbers. auto: all; for .npy and .nii, id or the only grid; for .dds, "
                           ".ktx2 and .png, Cd or the only grid."))
      .parameter(
          Parameter::choice("regions", "particles", {"particles", "phases"})
              .doc_(".vti, .vtu, .dream3d, .inp, .tesr, .foam, .msh: what has a number, element set or "
                    "surface of its own, besides "
                    "the binder: every particle, or every class of particles and all voids together (needs "
                    "particles)."))
      .parameter(Parameter::integer("smoothing", 10)
                     .range(0, 1000)
                     .doc_(".msh, .foam, and .stl of a volume: how often each node moves toward the mean of "
                           "its neighbors on "
                           "the same surface, by at most half a voxel in all. 0: faces of voxels."))
      .parameter(Parameter::choice("shader", "standard_surface", {"standard_surface", "open_pbr_surface"})
                     .doc_(".mtlx: standard_surface: MaterialX 1.38. open_pbr_surface: MaterialX 1.39."))
      .parameter(
          Parameter::with_keyword(ParameterKind::Texts, "pack", "none")
              .count(1, 4)
              .doc_(".png, .tif, .exr of texture maps: what each channel holds, such as [occlusion, "
                    "roughness, black] or [black, occlusion, white, 1-roughness]: a map, with .g or .b "
                    "for its other channels and 1- before it for one minus its value, or black or "
                    "white. none: one map in a file of its own."))
      .parameter(Parameter::choice("compression", "zlib", {"zlib", "none"})
                     .doc_(".vti, .vtu, .dream3d: compression of the voxels."))
      .writes_files_()
      .compute_(compute);
}

}  // namespace terrazzo

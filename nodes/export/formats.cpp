#include "nodes/export/formats.h"

#include <algorithm>
#include <filesystem>

#include "graph/diagnostic.h"
#include "nodes/export/formats/material_maps.h"
#include "nodes/export/writers.h"

namespace terrazzo::exporting {

namespace {

std::vector<std::string> with_maps(std::vector<std::string> types) {
  for (const MapName& map : kMaps) types.push_back(map.name);
  return types;
}

}  // namespace

const std::vector<Format>& formats() {
  static const std::vector<std::pair<std::string, std::string>> kPictures = {
      {"Profiles", "Image"}, {"Profiles", "Labels"}, {"Labels", "Image"}};
  static const std::vector<Format> all = {
      {".glb", with_maps({"Particles", "Shapes", "Image"}), {}, true, write_glb_file},
      {".mtlx", with_maps({}), {"base_color"}, true, write_materialx_file},
      {".usda", {"Particles", "Shapes", "Volume"}, {"Shapes"}, true, write_scene},
      {".xml", {"Particles", "Shapes", "Volume"}, {"Shapes", "Particles"}, true, write_scene},
      {".pbrt", {"Particles", "Shapes", "Volume"}, {"Shapes", "Particles"}, true, write_scene},
      {".nvdb", {"Volume"}, {}, false, write_nvdb_file},
      {".vdb", {"Volume"}, {}, false, write_vdb_file},
      {".vti", {"Volume", "Particles", "Table"}, {"Volume"}, true, write_voxels<export_vti>},
      {".vtu", {"Volume", "Particles"}, {"Volume"}, true, write_voxels<export_vtu>},
      {".dream3d", {"Volume", "Particles", "Table"}, {"Volume"}, true, write_voxels<export_dream3d>},
      {".inp", {"Volume", "Particles", "Table"}, {"Volume"}, true, write_voxels<export_inp>},
      {".tesr", {"Volume", "Particles", "Table"}, {"Volume"}, true, write_voxels<export_tesr>},
      {".foam", {"Volume", "Particles"}, {"Volume"}, true, write_voxels<export_foam>},
      {".lmp", {"Particles", "Shapes", "Table"}, {"Shapes", "Particles"}, true, write_lammps_file},
      {".npy", {"Volume", "Labels"}, {}, false, write_npy_file},
      {".nii.gz", {"Volume"}, {}, false, write_nifti_file},
      {".nii", {"Volume"}, {}, false, write_nifti_file},
      {".dds", {"Volume"}, {}, false, write_solid_texture},
      {".ktx2", {"Volume"}, {}, false, write_solid_texture},
      {".png", with_maps({"Image", "Labels", "Volume"}), {}, false, write_pictures},
      {".tif", with_maps({"Image", "Labels"}), {}, false, write_pictures},
      {".exr", with_maps({"Image", "Labels"}), {}, false, write_pictures},
      {".jpg", {"Image", "base_color"}, {}, false, write_pictures},
      {".hdr", {"Image", "base_color"}, {}, false, write_pictures},
      {".csv",
       {"Table", "Profiles", "Particles", "SizeDistribution", "KMatrix", "Shapes"},
       {},
       false,
       write_csv_file,
       {{"Profiles", "Image"}, {"Profiles", "Labels"}, {"Particles", "Shapes"}}},
      {".geojson", {"Profiles", "Labels"}, {}, false, write_outlines, kPictures},
      {".coco.json", {"Profiles", "Labels"}, {}, false, write_outlines, kPictures},
      {".roi", {"Profiles", "Labels"}, {}, false, write_outlines, kPictures},
      {".zip", {"Profiles", "Labels"}, {}, false, write_outlines, kPictures},
      {".json", {}, {}, true, write_json_file},
      {".obj", {"Shapes", "Particles"}, {}, false, write_mesh_file, {{"Particles", "Shapes"}}},
      {".ply", {"Shapes", "Particles"}, {}, false, write_mesh_file, {{"Particles", "Shapes"}}},
      {".stl", {"Shapes", "Volume", "Particles"}, {}, true, write_stl_file},
      {".msh", {"Volume", "Particles"}, {"Volume"}, true, write_surfaces},
  };
  return all;
}

namespace {

std::string joined(const std::vector<std::string>& words, const char* last) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i)
    out += (i == 0 ? "" : i + 1 == words.size() ? std::string(" ") + last + " " : ", ") + words[i];
  return out;
}

}  // namespace

const Format& format_of(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  for (const Format& f : formats())
    if (name.size() > f.extension.size() && name.ends_with(f.extension)) return f;
  const std::string extension = std::filesystem::path(path).extension().string();
  std::vector<std::string> known;
  for (const Format& f : formats()) known.push_back(f.extension);
  throw Error("unknown-format",
              extension.empty() ? "the file name has no extension"
                                : "the file extension '" + extension + "' is unknown",
              "use " + joined(known, "or"))
      .parameter("path");
}

void check_fit(const Format& format, const std::map<std::string, Value>& connected) {
  if (format.types.empty()) return;
  std::map<std::string, Value> values = connected;
  for (const auto& [type, other] : format.additions)
    if (values.count(type)) values.erase(other);
  std::vector<std::string> strangers;
  for (const auto& [type, value] : values)
    if (std::find(format.types.begin(), format.types.end(), type) == format.types.end())
      strangers.push_back(type);
  const std::string holds =
      "a " + format.extension + " file holds " + joined(format.types, format.several ? "and" : "or");
  if (!strangers.empty())
    throw Error("format-does-not-fit", holds + ", not " + joined(strangers, "and"),
                "change the extension or the input")
        .parameter("path");
  if (values.size() > 1 && !format.several)
    throw Error("format-does-not-fit", holds + ", but only one of them", "use one Export node for each")
        .parameter("path");
  for (const std::string& type : format.required) require_value(format, values, type);
}

void require_value(const Format& format, const std::map<std::string, Value>& values,
                   const std::string& type) {
  if (values.count(type)) return;
  if (type == "Shapes")
    throw Error("no-shapes",
                "particles are written as instances of their shapes, but 'shapes' is not connected",
                "connect the shapes used in the packing");
  throw Error("missing-input", "a " + format.extension + " file needs " + type,
              "connect it, or change the extension");
}

std::string beside(const std::string& path, const Format& format, const std::string& end) {
  return path.substr(0, path.size() - format.extension.size()) + end;
}

}  // namespace terrazzo::exporting

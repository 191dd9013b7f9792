#include "nodes/export/writers.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "nodes/common/io/checked_file.h"
#include "nodes/common/stereology/profile_columns.h"
#include "nodes/export/formats/csv.h"
#include "nodes/export/formats/gltf.h"
#include "nodes/export/formats/materialx_file.h"
#include "nodes/export/formats/mesh_file.h"
#include "nodes/export/formats/nifti_file.h"
#include "nodes/export/formats/npy_file.h"
#include "nodes/export/formats/nvdb_file.h"
#include "nodes/export/formats/outlines/outlines.h"
#include "nodes/export/formats/picture_file.h"
#include "nodes/export/formats/shapes_json.h"
#include "nodes/export/formats/solid_texture.h"
#include "nodes/export/formats/solvers/lammps_file.h"
#include "nodes/export/formats/vdb_file.h"
#include "nodes/export/outputs.h"
#include "runtime/json_text.h"

namespace terrazzo::exporting {
namespace fs = std::filesystem;
namespace {

std::string csv_of_value(const Value& v) {
  if (v.is<Table>()) return csv_of(v.as<Table>());
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
    for (const Input& in : kInputs)
      if (type == in.type) key = in.name;
    all[key] = describe(v);
  }
  return json_text(all, 2) + "\n";
}

// Writes one file per section.
template <class Picture, class Write>
void write_sections(const Job& job, const Picture& picture, Write&& write) {
  Context& c = job.context;
  const std::string made_by = c.provenance();
  if (picture.sections < 1) throw Error("empty-image", "the image has no sections");
  for (int s = 0; s < picture.sections; ++s) {
    c.work().check();
    c.work().progress(double(s) / picture.sections);
    write_named(c, picture.sections == 1 ? job.path : section_name(job.path, s, picture.sections),
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

// The grids of a texture: those that the parameter names, else Cd or the only one.
std::vector<std::string> texture_grids(const Context& c, const Volume& volume) {
  const auto all = grid_names(volume);
  if (c.keyword("grids").empty()) return c.texts("grids");
  if (std::find(all.begin(), all.end(), "Cd") != all.end()) return {"Cd"};
  if (all.size() > 1)
    throw Error("several-grids",
                fmt::format("a texture holds one grid; the volume has {}", fmt::join(all, ", ")),
                "name one of them with grids")
        .parameter("grids");
  if (all.empty()) throw Error("no-grids", "the volume has no grids to write");
  return all;
}

// The packing as the parameter crossing has it.
TiledPacking packing_of(const Job& job, bool flat_caps) {
  require_value(job.format, job.values, "Shapes");
  Context& c = job.context;
  const auto crossing = c.choice<Crossing>("crossing");
  TiledPacking out = tiled_packing(*job.particles(), *job.find<Shapes>("Shapes"), crossing, flat_caps,
                                   c.memory(), c.work().part(0, 0.5));
  if (crossing != Crossing::Once) c.metric("instances", out.particles.count());
  if (crossing == Crossing::Cut) {
    c.metric("parts", out.parts);
    c.metric("fraction", out.fraction);
  }
  return out;
}

}  // namespace

PictureSize Job::picture(const Profiles& profiles) const {
  PictureSize out;
  if (const Image* image = find<Image>("Image"))
    out = {image->width, image->height, image->sections, image->pixel_size, image->georeference};
  else if (const Labels* labels = find<Labels>("Labels"))
    out = {labels->width, labels->height, labels->sections, labels->pixel_size, {}};
  if (out.pixel_size > 0) require_picture(profiles, out.width, out.height, out.sections, out.pixel_size);
  return out;
}

std::optional<Georeference> Job::place_of(const Labels& labels) const {
  const Image* image = find<Image>("Image");
  if (!image) return {};
  if (image->width != labels.width || image->height != labels.height || image->sections != labels.sections)
    throw Error("size-mismatch",
                fmt::format("the labels have {} sections of {} × {} pixels, but the image has {} of {} × {}",
                            labels.sections, labels.width, labels.height, image->sections, image->width,
                            image->height),
                "connect the picture of the labels");
  return image->georeference;
}

MaterialMaps Job::maps() const {
  MaterialMaps out;
  for (const MapName& map : kMaps) out.*map.image = find<Image>(map.name);
  return out;
}

void write_csv_file(const Job& job) {
  std::string text;
  if (const Profiles* profiles = job.find<Profiles>("Profiles"))
    text =
        csv_of(*profiles, {job.picture(*profiles).pixel_size, job.find<Image>("Image")}, job.context.work());
  else if (const Particles* particles = job.particles())
    text = csv_of(*particles, job.find<Shapes>("Shapes"));
  else
    text = csv_of_value(job.only());
  write_named(job.context, job.path, [&](const fs::path& file) { write_bytes(file, text); });
}

void write_glb_file(const Job& job) {
  Context& c = job.context;
  const MaterialMaps maps = job.maps();
  if (std::any_of(kMaps.begin(), kMaps.end(), [&](const MapName& map) { return maps.*map.image; })) {
    const Shapes* shapes = job.find<Shapes>("Shapes");
    if (job.find<Image>("Image") || job.particles() || (shapes && shapes->shapes.size() != 1))
      throw Error("format-does-not-fit",
                  "texture maps are shown on a plane or on one shape, not with particles or an image",
                  "use one Export node for each")
          .parameter("path");
    return write_named(c, job.path, [&](const fs::path& file) {
      write_glb(file, maps, c.provenance(), shapes ? &shapes->shapes[0] : nullptr);
    });
  }
  require_value(job.format, job.values, "Shapes");
  const Shapes& shapes = *job.find<Shapes>("Shapes");
  const Image* texture = job.find<Image>("Image");
  const Particles* particles = job.particles();
  if (particles && texture)
    throw Error("no-uv", "an image is the texture of shapes without particles; both are connected",
                "disconnect the image or the particles");
  std::optional<TiledPacking> packing;
  if (particles) packing = packing_of(job, true);
  write_named(c, job.path, [&](const fs::path& file) {
    if (packing)
      write_glb(file, packing->particles, packing->shapes, c.provenance(), c.work().part(0.5, 1),
                c.choice<Instancing>("instancing"), static_cast<int>(c.integer("materials")), packing->index);
    else
      write_glb(file, shapes, c.provenance(), c.work(), texture);
  });
}

void write_lammps_file(const Job& job) {
  std::optional<SolverMaterials> materials;
  if (const Table* table = job.find<Table>("Table")) materials.emplace(*table);
  write_named(job.context, job.path, [&](const fs::path& file) {
    write_lammps(file, *job.particles(), *job.find<Shapes>("Shapes"), materials ? &*materials : nullptr,
                 job.context.work());
  });
}

void write_json_file(const Job& job) {
  write_named(job.context, job.path,
              [&](const fs::path& file) { write_bytes(file, json_text_of(job.values)); });
}

void write_materialx_file(const Job& job) {
  Context& c = job.context;
  const MaterialMaps maps = job.maps();
  const std::string made_by = c.provenance();
  for (const MapName& map : kMaps) {
    c.work().check();
    if (const Image* image = maps.*map.image)
      write_named(c, (fs::path(job.path).parent_path() / map.file).string(),
                  [&](const fs::path& file) { write_map(file, map, *image, made_by); });
  }
  write_named(c, job.path, [&](const fs::path& file) {
    write_materialx(file, maps, c.choice<SurfaceShader>("shader"), made_by);
  });
}

void write_mesh_file(const Job& job) {
  std::optional<TiledPacking> packing;
  if (job.particles()) packing = packing_of(job, false);
  write_named(job.context, job.path, [&](const fs::path& file) {
    if (packing)
      write_mesh(file, packing->particles, packing->shapes, job.context.work().part(0.5, 1));
    else
      write_mesh(file, *job.find<Shapes>("Shapes"));
  });
}

void write_nifti_file(const Job& job) {
  Context& c = job.context;
  write_named(c, job.path, [&](const fs::path& file) {
    const VoxelBox box = voxel_box(*job.volume());
    write_nifti(file, only_grid(c, *job.volume(), box), box, c.provenance(), c.work());
  });
}

void write_npy_file(const Job& job) {
  Context& c = job.context;
  write_named(c, job.path, [&](const fs::path& file) {
    if (const Labels* labels = job.find<Labels>("Labels")) return write_npy(file, *labels);
    const VoxelBox box = voxel_box(*job.volume());
    write_npy(file, only_grid(c, *job.volume(), box), box, c.work());
  });
}

void write_nvdb_file(const Job& job) {
  Context& c = job.context;
  write_named(c, job.path,
              [&](const fs::path& file) { write_nvdb(file, grids_for_nvdb(c, *job.volume()), c.work()); });
}

void write_outlines(const Job& job) {
  const Profiles* profiles = job.find<Profiles>("Profiles");
  const PictureSize picture = profiles ? job.picture(*profiles) : PictureSize{};
  if (profiles && picture.pixel_size == 0)
    throw Error("missing-input",
                "a " + job.format.extension + " file is in pixels, whose size profiles do not know",
                "connect the picture of the profiles to image, or their labels");
  OutlineFile all = profiles ? outlines_of(*profiles, picture.width, picture.height, picture.pixel_size)
                             : outlines_of(*job.find<Labels>("Labels"));
  all.georeference = profiles ? picture.georeference : job.place_of(*job.find<Labels>("Labels"));
  if (all.outlines.empty())
    throw Error("no-profiles", "there are no profiles to write", "use a photograph that shows particles");
  const std::string& end = job.format.extension;
  if (end == ".zip")
    return write_named(job.context, job.path, [&](const fs::path& file) { write_roi_zip(file, all); });
  if (end == ".roi" && all.outlines.size() > 1)
    throw Error("format-does-not-fit",
                fmt::format("a .roi file holds one region, but there are {}", all.outlines.size()),
                "use .zip")
        .parameter("path");
  const std::string text = end == ".roi"       ? roi_of(all.outlines[0], all.sections > 1, false)
                           : end == ".geojson" ? geojson_of(all)
                                               : coco_of(all);
  write_named(job.context, job.path, [&](const fs::path& file) { write_bytes(file, text); });
}

void write_pictures(const Job& job) {
  if (const Image* image = job.find<Image>("Image")) return write_sections(job, *image, write_picture);
  if (const Labels* labels = job.find<Labels>("Labels")) return write_sections(job, *labels, write_labels);
  if (job.volume()) return write_solid_texture(job);
  const MaterialMaps maps = job.maps();
  if (job.context.keyword("pack").empty())
    return write_named(job.context, job.path, [&](const fs::path& file) {
      write_packed_maps(file, maps, job.context.texts("pack"), job.context.provenance());
    });
  for (const MapName& map : kMaps)
    if (const Image* image = maps.*map.image)
      write_named(job.context, job.path,
                  [&](const fs::path& file) { write_map(file, map, *image, job.context.provenance()); });
}

void write_scene(const Job& job) {
  std::optional<TiledPacking> packing;
  if (job.particles()) packing = packing_of(job, true);
  export_scene(job.context, job.path, job.format, packing ? &*packing : nullptr, *job.find<Shapes>("Shapes"),
               job.volume());
}

void write_solid_texture(const Job& job) {
  Context& c = job.context;
  const Volume& volume = *job.volume();
  const std::vector<std::string> grids = texture_grids(c, volume);
  const std::string& end = job.format.extension;
  const bool picture = end == ".png";
  const SolidTexels texels = solid_texels(volume, grids, picture, c.memory(), c.work().part(0, 0.5));
  if (picture) {
    c.metric("columns", atlas_columns(texels.size.z()));
    c.metric("rows", atlas_rows(texels.size.z()));
  }
  write_named(c, job.path, [&](const fs::path& file) {
    if (picture)
      write_slice_atlas(file, texels, c.provenance());
    else if (end == ".dds")
      write_dds(file, texels);
    else
      write_ktx2(file, texels, c.provenance());
  });
}

void write_stl_file(const Job& job) {
  if (!job.find<Shapes>("Shapes")) return write_surfaces(job);
  if (job.volume())
    throw Error("format-does-not-fit", "a .stl file holds shapes or the surface of a volume, not both",
                "use one Export node for each")
        .parameter("path");
  write_mesh_file(job);
}

void write_surfaces(const Job& job) {
  if (!job.volume())
    throw Error("missing-input", "particles without their shapes and volume have no surface",
                "connect the shapes, or Voxelize.volume");
  write_voxels<export_surfaces>(job);
}

void write_vdb_file(const Job& job) {
  Context& c = job.context;
  write_named(c, job.path, [&](const fs::path& file) {
    write_vdb(file, chosen_grids(c, *job.volume()), c.provenance(), c.choice<WholeNumbers>("id_type"));
  });
}

}  // namespace terrazzo::exporting

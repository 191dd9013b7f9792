// Scenes, with the meshes and volumes beside them.
#include <algorithm>

#include "nodes/common/geometry/mesh/render_mesh.h"
#include "nodes/export/formats/mitsuba_file.h"
#include "nodes/export/formats/nvdb_file.h"
#include "nodes/export/formats/pbrt_file.h"
#include "nodes/export/formats/usda_file.h"
#include "nodes/export/formats/vdb_file.h"
#include "nodes/export/instances.h"
#include "nodes/export/outputs.h"

namespace terrazzo::exporting {
namespace {

void export_usda(Context& c, const std::string& path, const Format& format, const TiledPacking* packing,
                 const Shapes& shapes, const Volume* volume) {
  if (packing)
    instances_of(packing->particles, packing->shapes);  // throws before the first of two files is written
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
    if (packing)
      write_usda(file, packing->particles, packing->shapes, beside_it, c.provenance(), c.work(),
                 packing->index);
    else
      write_usda(file, shapes, beside_it, c.provenance(), c.work());
  });
}

// Mitsuba and pbrt.
void export_rendering(Context& c, const std::string& path, const Format& format, const Particles& particles,
                      const Shapes& shapes, const Volume* volume) {
  namespace fs = std::filesystem;
  const std::string stem = fs::path(beside(path, format, "")).filename().string();
  Scene scene = scene_of(particles, shapes, stem, c.integer("materials"));
  for (std::size_t s = 0; s < shapes.shapes.size(); ++s)
    if (!scene.mesh_files[s].empty()) render_mesh(shapes.shapes[s]);  // throws before anything is written
  scene.provenance = c.provenance();
  const bool mitsuba = format.extension == ".xml";
  BinderMedium binder;
  if (volume) {
    binder = binder_medium(*volume, c.memory(), c.work().part(0, 0.3));
    scene.binder = &binder;
    const std::string end = mitsuba ? "_binder.vol" : "_binder.nvdb";
    scene.binder_file = stem + end;
    write_named(c, beside(path, format, end), [&](const fs::path& file) {
      if (mitsuba)
        write_mitsuba_volume(file, binder);
      else
        write_nvdb(file, "density", binder.box, binder.density, c.work().part(0.3, 0.6));
    });
  }
  const fs::path folder = fs::path(path).parent_path();
  for (std::size_t s = 0; s < shapes.shapes.size(); ++s)
    if (!scene.mesh_files[s].empty())
      write_named(c, (folder / scene.mesh_files[s]).generic_string(),
                  [&](const fs::path& file) { write_render_ply(file, shapes.shapes[s]); });
  write_named(c, path, [&](const fs::path& file) {
    (mitsuba ? write_mitsuba : write_pbrt)(file, scene, c.work().part(0.6, 1));
  });
}

}  // namespace

void export_scene(Context& c, const std::string& path, const Format& format, const TiledPacking* packing,
                  const Shapes& shapes, const Volume* volume) {
  if (format.extension == ".usda")
    export_usda(c, path, format, packing, shapes, volume);
  else
    export_rendering(c, path, format, packing->particles, packing->shapes, volume);
}

}  // namespace terrazzo::exporting

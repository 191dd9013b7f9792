// Files of voxels, with the files beside them.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "nodes/common/io/checked_file.h"
#include "nodes/export/formats/csv.h"
#include "nodes/export/formats/solvers/damask_files.h"
#include "nodes/export/formats/solvers/dream3d_file.h"
#include "nodes/export/formats/solvers/foam_case.h"
#include "nodes/export/formats/solvers/inp_file.h"
#include "nodes/export/formats/solvers/inp_job.h"
#include "nodes/export/formats/solvers/materials.h"
#include "nodes/export/formats/solvers/tesr_file.h"
#include "nodes/export/formats/solvers/vti_file.h"
#include "nodes/export/formats/solvers/vtu_file.h"
#include "nodes/export/formats/surface_file.h"
#include "nodes/export/outputs.h"

namespace terrazzo::exporting {
namespace {
namespace fs = std::filesystem;

// Named after the whole file name: block.vti and block.inp each have their own numbers.
void write_region_table(Context& c, const VoxelJob& job, const Regions& regions, const VoxelBox& box) {
  write_named(c, job.path + ".csv", [&](const fs::path& file) {
    write_bytes(file, csv_of(region_table(regions, box, job.particles)));
  });
}

std::optional<SolverMaterials> materials_of(const VoxelJob& job) {
  if (!job.materials) return {};
  return SolverMaterials(*job.materials);
}

// The grid id of a volume and its regions, to which the content of a file of voxels refers.
struct Identified {
  std::optional<VoxelSource> id;  // none if the volume has no such grid of whole numbers
  Regions regions;
};

bool has_id(const Volume& volume) {
  const auto all = grid_names(volume);
  return std::find(all.begin(), all.end(), "id") != all.end();
}

// Throws Error "no-id".
Identified required_regions(Context& c, const VoxelJob& job, const VoxelBox& box, double share) {
  if (!has_id(job.volume))
    throw Error("no-id", "the volume has no grid id, which tells particles apart", "connect Voxelize.volume");
  Identified out;
  out.id.emplace(job.volume, "id", box);
  out.regions =
      find_regions(*out.id, box, job.particles, c.choice<RegionKind>("regions"), c.work().part(0, share));
  return out;
}

// Fills in the parts that files of voxels share. `content` refers to the result. `lost`: what the file lacks
// without regions.
template <class Content>
std::unique_ptr<Identified> fill_content(Context& c, Content& content, const VoxelJob& job,
                                         const std::string& lost) {
  content.box = voxel_box(job.volume);
  content.provenance = c.provenance();
  for (const std::string& name : grid_names(chosen_grids(c, job.volume)))
    content.grids.emplace_back(job.volume, name, content.box);
  auto out = std::make_unique<Identified>();
  if (has_id(job.volume)) out->id.emplace(job.volume, "id", content.box);
  if (out->id && !out->id->whole()) {
    c.warn("the grid id does not contain whole numbers, so the file has no " + lost);
    out->id.reset();
  }
  if (!out->id && job.materials)
    throw Error("no-id", "the volume has no grid id of whole numbers, to which the table of materials refers",
                "connect Voxelize.volume, or disconnect the table");
  if (out->id) {
    out->regions = find_regions(*out->id, content.box, job.particles, c.choice<RegionKind>("regions"),
                                c.work().part(0, 0.2));
    content.id = &*out->id;
    content.regions = &out->regions;
  }
  return out;
}

// DAMASK counts materials from 0 and wants no others than those in the grid.
void number_present(Identified& found) {
  found.regions = selected_regions(found.regions, [](const Region& r) { return r.voxels > 0; });
}

// Crystals that were never turned are an oversight.
void warn_of_equal_orientations(Context& c, const VoxelJob& job, const SolverMaterials& materials,
                                const Regions& regions) {
  if (!job.particles) return;
  std::size_t crystals = 0, turned = 0;
  const Region* first = nullptr;
  for (const Region& r : regions.all) {
    if (r.voxels == 0 || materials.of(r).stiffness->isotropic()) continue;
    if (!first) first = &r;
    ++crystals;
    turned += !job.particles->orientation[r.particle].isApprox(job.particles->orientation[first->particle]);
  }
  if (crystals > 1 && turned == 0)
    c.warn(
        fmt::format("all {} crystals have the same orientation: set crystal_axes of Tessellate", crystals));
}

}  // namespace

void export_vti(Context& c, const VoxelJob& job) {
  VtiContent content;
  content.compression = c.choice<VtkCompression>("compression");
  const auto materials = materials_of(job);
  const auto found = fill_content(c, content, job, "array material");
  number_present(*found);
  if (materials) {
    check_damask(found->regions, *materials, job.particles);
    warn_of_equal_orientations(c, job, *materials, found->regions);
  }
  write_named(c, job.path, [&](const fs::path& file) { write_vti(file, content, c.work().part(0.2, 1)); });
  if (found->id) write_region_table(c, job, found->regions, content.box);
  if (!materials) return;
  write_named(c, beside(job.path, job.format, "_material.yaml"), [&](const fs::path& file) {
    write_damask_material(file, found->regions, *materials, job.particles, c.provenance());
  });
  write_named(c, beside(job.path, job.format, "_load.yaml"), write_damask_load);
}

void export_vtu(Context& c, const VoxelJob& job) {
  VtiContent content;
  content.compression = c.choice<VtkCompression>("compression");
  const auto found = fill_content(c, content, job, "array material");
  number_present(*found);
  write_named(c, job.path,
              [&](const fs::path& file) { write_vtu(file, content, c.memory(), c.work().part(0.2, 1)); });
  if (found->id) write_region_table(c, job, found->regions, content.box);
}

void export_dream3d(Context& c, const VoxelJob& job) {
  Dream3dContent content;
  content.particles = job.particles;
  content.compress = c.choice<VtkCompression>("compression") == VtkCompression::Zlib;
  const auto materials = materials_of(job);
  if (materials) content.materials = &*materials;
  const auto found = fill_content(c, content, job, "features");
  write_named(c, job.path,
              [&](const fs::path& file) { write_dream3d(file, content, c.work().part(0.2, 1)); });
}

void export_inp(Context& c, const VoxelJob& job) {
  const VoxelBox box = voxel_box(job.volume);
  check_inp(box);
  const auto materials = materials_of(job);
  const Identified found = required_regions(c, job, box, 0.1);
  const auto named = [&](const char* end) { return beside(job.path, job.format, end); };
  const auto name_of = [](const std::string& path) { return fs::path(path).filename().string(); };
  const InpJob parts{name_of(job.path), box.periodic ? name_of(named("_periodic.inp")) : "",
                     name_of(named("_materials.inp"))};
  if (materials) {
    check_inp_job(parts);
    materials->require_stiffness(found.regions, job.particles != nullptr);
    warn_of_equal_orientations(c, job, *materials, found.regions);
    write_named(c, named("_materials.inp"), [&](const fs::path& file) {
      write_inp_materials(file, found.regions, *materials, job.particles);
    });
  }
  write_named(c, job.path, [&](const fs::path& file) {
    write_inp(file, *found.id, box, found.regions, c.memory(), c.provenance(), c.work().part(0.1, 0.9));
  });
  if (box.periodic)
    write_named(c, named("_periodic.inp"),
                [&](const fs::path& file) { write_periodic_inp(file, box, c.work().part(0.9, 1)); });
  write_region_table(c, job, found.regions, box);
  if (materials)  // last, so that a job without its parts is never new
    write_named(c, named("_job.inp"), [&](const fs::path& file) { write_inp_job(file, parts, box); });
}

void export_tesr(Context& c, const VoxelJob& job) {
  const VoxelBox box = voxel_box(job.volume);
  const auto materials = materials_of(job);
  const Identified found = required_regions(c, job, box, 0.2);
  std::size_t empty = 0;
  for (const Region& r : found.regions.all)
    if (r.is == Region::Is::Void || r.is == Region::Is::Binder) empty += r.voxels;
  if (empty > 0)
    c.warn(fmt::format("{:.3g} % of the volume is binder or void, which a .tesr file leaves empty",
                       100.0 * double(empty) / double(box.count())));
  const Regions cells = selected_regions(found.regions, [](const Region& r) {
    return r.is == Region::Is::Binder || (r.is != Region::Is::Void && r.voxels > 0);
  });
  write_named(c, job.path, [&](const fs::path& file) {
    write_tesr(file, *found.id, box, cells, job.particles, materials ? &*materials : nullptr,
               c.work().part(0.2, 1));
  });
  write_region_table(c, job, cells, box);
}

void export_foam(Context& c, const VoxelJob& job) {
  const VoxelBox box = voxel_box(job.volume);
  const Identified found = required_regions(c, job, box, 0.1);
  const Vec3 inside = inside_of_binder(*found.id, box, found.regions, c.memory(), c.work().quiet());
  const SurfaceNet net =
      surface_net(*found.id, box, found.regions, c.integer("smoothing"), c.memory(), c.work().part(0.1, 0.6));
  std::size_t pieces = 0;
  for (const std::int32_t region : net.region_of_piece) pieces += region == 0;
  if (pieces > 1)
    c.warn(fmt::format("the binder has {} pieces in the box; snappyHexMesh meshes one of them", pieces));
  const fs::path folder = fs::path(job.path).parent_path();
  const std::string stl = beside(fs::path(job.path).filename().string(), job.format, ".stl");
  if (stl.find_first_of("\"\\$;{}") != std::string::npos)
    throw Error("bad-names", "a dictionary of OpenFOAM cannot contain the file name '" + stl + "'",
                "rename it")
        .parameter("path");
  write_named(c, (folder / "constant" / "triSurface" / stl).string(), [&](const fs::path& file) {
    write_foam_surface(file, net, found.regions, c.work().part(0.6, 1));
  });
  for (const auto& [path, text] : foam_dictionaries(stl, net, box, found.regions, inside))
    write_named(c, (folder / path).string(), [&](const fs::path& file) { write_bytes(file, text); });
  write_named(c, job.path, [&](const fs::path& file) {
    write_bytes(file, "Terrazzo: blockMesh && snappyHexMesh -overwrite\n");
  });
}

void export_surfaces(Context& c, const VoxelJob& job) {
  const VoxelBox box = voxel_box(job.volume);
  const Identified found = required_regions(c, job, box, 0.1);
  const SurfaceNet net =
      surface_net(*found.id, box, found.regions, c.integer("smoothing"), c.memory(), c.work().part(0.1, 0.6));
  c.metric("nodes", net.nodes.size());
  c.metric("triangles", net.corners.size());
  const bool msh = job.format.extension == ".msh";
  write_named(c, job.path, [&](const fs::path& file) {
    (msh ? write_msh : write_surface_stl)(file, net, found.regions, c.work().part(0.6, 1));
  });
  if (!msh) return;
  write_named(c, beside(job.path, job.format, ".geo"), [&](const fs::path& file) {
    write_geo(file, fs::path(job.path).filename().string(), net, found.regions);
  });
  write_region_table(c, job, found.regions, box);
}

}  // namespace terrazzo::exporting

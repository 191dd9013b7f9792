// Files of voxels, with the tables beside them.
#include <algorithm>
#include <memory>
#include <optional>

#include "nodes/common/io/checked_file.h"
#include "nodes/export/formats/csv.h"
#include "nodes/export/formats/dream3d_file.h"
#include "nodes/export/formats/inp_file.h"
#include "nodes/export/formats/surface_file.h"
#include "nodes/export/formats/vti_file.h"
#include "nodes/export/outputs.h"

namespace terrazzo::exporting {
namespace {

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
    content.id = &*out->id;
    content.regions = &out->regions;
  }
  return out;
}

}  // namespace

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
  content.compress = c.choice<VtiCompression>("compression") == VtiCompression::Zlib;
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

void export_surfaces(Context& c, const std::string& path, const Format& format, const Volume& volume,
                     const Particles* particles) {
  const VoxelBox box = voxel_box(volume);
  const auto all = grid_names(volume);
  if (std::find(all.begin(), all.end(), "id") == all.end())
    throw Error("no-id", "the volume has no grid id, which tells particles apart", "connect Voxelize.volume");
  const VoxelSource id(volume, "id", box);
  const Regions regions =
      find_regions(id, box, particles, c.choice<RegionKind>("regions"), c.work().part(0, 0.1));
  const SurfaceNet net =
      surface_net(id, box, regions, c.integer("smoothing"), c.memory(), c.work().part(0.1, 0.6));
  c.metric("nodes", net.nodes.size());
  c.metric("triangles", net.corners.size());
  write_named(c, path, [&](const std::filesystem::path& file) {
    (format.extension == ".msh" ? write_msh : write_surface_stl)(file, net, regions, c.work().part(0.6, 1));
  });
  if (format.extension != ".msh") return;
  write_named(c, beside(path, format, ".geo"), [&](const std::filesystem::path& file) {
    write_geo(file, std::filesystem::path(path).filename().string(), net, regions);
  });
  write_region_table(c, path, regions, box, particles);
}

}  // namespace terrazzo::exporting

// What the writers of Export share: files below the output folder, and the grids that the parameters choose.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/table.h"
#include "nodes/export/formats.h"
#include "nodes/export/tiled_packing.h"
#include "runtime/context.h"

namespace terrazzo::exporting {

// Calls `write` with a temporary file, which then becomes `path`, relative to the output folder. Errors of
// the disk name the path that the user gave.
void write_named(Context&, const std::string& path,
                 const std::function<void(const std::filesystem::path&)>& write);

// The volume with the grids that the parameter `grids` names, or all. Throws Error "no-such-grid".
Volume chosen_grids(const Context&, const Volume&);

// The one grid of a file that holds only one. Throws Error "several-grids", "no-such-grid".
VoxelSource only_grid(const Context&, const Volume&, const VoxelBox&);

// --- the formats of several files. `path` is that of the first. Each throws the errors of its writers.

// What a file of voxels is made of. All but the volume may be null.
struct VoxelJob {
  const std::string& path;
  const Format& format;
  const Volume& volume;
  const Particles* particles = nullptr;
  const Table* materials = nullptr;
};
void export_vti(Context&, const VoxelJob&);
void export_vtu(Context&, const VoxelJob&);
void export_dream3d(Context&, const VoxelJob&);
void export_inp(Context&, const VoxelJob&);
void export_tesr(Context&, const VoxelJob&);
void export_foam(Context&, const VoxelJob&);
void export_surfaces(Context&, const VoxelJob&);  // of the regions of a volume: .msh, .stl
// .usda, .xml (Mitsuba) and .pbrt. `volume` may be null, and for .usda also `packing`: then the shapes are
// written.
void export_scene(Context&, const std::string& path, const Format&, const TiledPacking* packing,
                  const Shapes&, const Volume* volume);

}  // namespace terrazzo::exporting

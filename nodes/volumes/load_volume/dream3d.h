// Reader of DREAM3D files (.dream3d, HDF5, file version 7.0 of DREAM3D 6).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "nodes/common/io/reading.h"
#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo::load_volume {

bool is_hdf5(const std::filesystem::path&);

// The cell data of the first image geometry as grids of the same names, with types as for VTK files.
// FeatureIds become the grid `id`, less 1: feature 0, which DREAM3D takes for unassigned, is the binder. If
// the file has an array `id`, from which Export made FeatureIds and Phases, these two are left out. With
// `grid` only that array. Arrays that are no single numbers or three, and further geometries, are left out
// with a warning. Lengths are micrometers; `spacing` (mm) overrides them. Throws Error "unreadable-volume",
// "not-a-volume" (no image geometry, no cell data), "no-such-grid", "too-large", "bad-values", "no-spacing".
Volume read_dream3d(const std::filesystem::path&, const std::string& grid, std::optional<Vec3> spacing,
                    const Reading& = {}, const Work& = {});

}  // namespace terrazzo::load_volume

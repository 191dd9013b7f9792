// Grids from functions of the voxel number, for files that do without OpenVDB's headers. dense_grid.h makes
// any grid.
#pragma once

#include <cstdint>
#include <functional>

#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo {

// The first two add a grid whose `size` voxels are all active. `value(i)` returns voxel number (z·ny + y)·nx
// + x and may be called from several threads. `spacing` and `voxel` are edge lengths in mm, `first` is the
// first voxel.
void add_number_grid(Volume&, const std::string& name, const Vec3i& size, const Vec3& spacing, const Work&,
                     const std::function<float(std::size_t)>& value, const Vec3i& first = Vec3i::Zero());
void add_vector_grid(Volume&, const std::string& name, const Vec3i& size, double voxel, const Work&,
                     const std::function<Vec3f(std::size_t)>& value);

// Adds a grid of particle indices: int32, active where not negative, background −1.
void add_id_grid(Volume&, const std::string& name, const Vec3i& size, const Vec3& spacing, const Work&,
                 const std::function<std::int32_t(std::size_t)>& value);
// Adds the grid `phase`: int32, all active, background 0.
void add_phase_grid(Volume&, const Vec3i& size, const Vec3& spacing, const Work&,
                    const std::function<std::int32_t(std::size_t)>& value);

}  // namespace terrazzo

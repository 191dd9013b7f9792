// Grids from arrays with one number or vector per voxel, as files of other programs contain them.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "nodes/common/io/reading.h"
#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo::load_volume {

// A type of numbers, little-endian.
struct CellNumber {
  std::size_t bytes;
  bool whole;
  double (*read)(const char*);
};
// Null if there is no such type.
const CellNumber* cell_number(bool whole, bool is_signed, std::size_t bytes);

struct CellPlace {
  Vec3i size = Vec3i::Zero(), first = Vec3i::Zero();  // voxels
  Vec3 spacing = Vec3::Ones();                        // mm
};
// `first`: the first voxel's place in voxels, which is rounded, with a warning if it is not whole. `given`
// overrides the spacing. Throws Error "no-spacing".
CellPlace cell_place(const Vec3i& size, const Vec3& spacing, const Vec3& first, std::optional<Vec3> given,
                     const Reading&);

// Makes the place the extent of a volume that does not tile.
void place_volume(Volume&, const CellPlace&);

// Whole numbers become int32, three of them vec3i; others float and vec3s. The grid `id` becomes inactive
// where it is negative, with the background −1. `add` is added to every number. Throws Error "bad-values"
// (NaN, infinity, or beyond the grid's type).
std::shared_ptr<openvdb::GridBase> cell_grid(const std::string& name, const CellNumber&, int components,
                                             const std::string& bytes, const CellPlace&, int add,
                                             const Work&);

}  // namespace terrazzo::load_volume

// A volume as plain arrays of voxels, a few planes at a time, so that no reader needs a whole grid in memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/opaque_volume.h"

namespace terrazzo {

// The voxels of a volume: one period, or its extent, or the active voxels of all grids if neither is known.
struct VoxelBox {
  Vec3i first = Vec3i::Zero(), size = Vec3i::Zero();  // voxels
  Vec3 spacing = Vec3::Ones();                        // edges of a voxel, mm
  Vec3 corner = Vec3::Zero();                         // lower corner of the first voxel, mm
  bool periodic = false;

  std::size_t plane() const { return pixels_in(size.x(), size.y()); }
  std::size_t count() const { return plane() * size.z(); }
};

// Throws Error "no-grids", "empty-volume" (no active voxel), "tilted-volume" (voxel edges that are not along
// +x, +y and +z), "size-mismatch" (grids with different transforms).
VoxelBox voxel_box(const Volume&);

std::vector<std::string> grid_names(const Volume&);

// One grid of a volume.
class VoxelSource {
 public:
  // Throws Error "no-such-grid", "unsupported-grid", "bad-values" if a voxel is NaN or infinite.
  VoxelSource(const Volume&, const std::string& grid, const VoxelBox&);

  const std::string& name() const { return name_; }
  int components() const { return components_; }  // 1 or 3
  bool whole() const { return whole_; }           // whether the values are whole numbers
  bool yes_no() const { return yes_no_; }         // whether they are only 0 and 1, those of a bool grid
  std::size_t voxel_bytes() const { return 4 * static_cast<std::size_t>(components_); }
  bool level_set() const { return level_set_; }  // whether the values are signed distances in mm
  // Reads the planes z0 ≤ z < z1 of the box: x fastest, a voxel's components together. Grids of whole numbers
  // give std::int32_t (bool: 0 or 1), the others float. Several threads may read at once.
  void read(int z0, int z1, void* out) const;

 private:
  std::shared_ptr<const openvdb::GridBase> grid_;
  VoxelBox box_;
  std::string name_;
  int components_ = 1;
  bool whole_ = false, yes_no_ = false, level_set_ = false;
};

}  // namespace terrazzo

// The voxels of a volume by phase.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nodes/packing/measure3d/raster.h"

namespace terrazzo::measure3d {

constexpr std::size_t kMostClasses = 64;  // labels of a volume that are measured one by one

// Disjoint phases that fill the box.
struct Classes {
  VoxelBox box;
  std::vector<std::uint8_t> of;     // class of each voxel, x fastest
  std::vector<std::string> name;    // of each class: its label, or "binder", "rest", "particles", "voids"
  std::vector<std::size_t> voxels;  // of each class
  // Whether voxels of the class are connected only by their faces (6 neighbors), not by corners too (26), in
  // its Euler number. So is the binder, because (26, 6) and (6, 26) are complementary.
  std::vector<char> faces_only;
  std::vector<char> wanted;  // whether its local thickness is to be found, which takes longest

  std::size_t count() const { return name.size(); }
  double voxel_volume() const { return box.spacing.prod(); }  // mm³
};

// The labels of a raster in increasing order, with "binder" first if it occurs. Nothing if the raster has no
// labels, or not 2 to 64 of them.
std::optional<Classes> classes_of_labels(const Raster&, const Work&);

// "rest", then the phase of the raster.
Classes classes_of_phase(const Raster&, Phase);

}  // namespace terrazzo::measure3d

// Plane sections of a volume.
#pragma once

#include "nodes/bodies/cutting/section.h"
#include "nodes/data/opaque_volume.h"

namespace terrazzo::section {

// The box in which planes are placed: one period, or the bounding box of the active voxels if the volume is
// not periodic.
struct VolumeBox {
  Vec3 corner = Vec3::Zero();  // mm
  Vec3 size = Vec3::Zero();    // mm
  bool periodic = false;
  double voxel = 1;  // mm, the shortest voxel edge
};
// Throws Error "no-grids" or "empty-volume".
VolumeBox volume_box(const Volume&);

// The image holds trilinear samples of `Cd`, or of `density` as gray, at pixel centers; if there are only
// phases, gray levels from 0 to 1 for these. Labels are 4-connected regions of equal `id` ≥ 0 (by majority
// among the surrounding voxels); if there is no id, of equal `phase` ≥ 1, whose class is that number less 1;
// or of density ≥ ½. Profiles are those regions, with areas counted in pixels and without contours. The
// layout is relative to the box's corner. Throws Error "no-color" if there is neither Cd, density nor phase,
// "too-many-phases".
struct VolumeSection : Section {
  std::string color_grid, label_grid;  // the grids used; label_grid is empty if there was none
};
VolumeSection cut_volume(const Volume&, const SectionLayout&, const Work& = {});

}  // namespace terrazzo::section

// What plane sections of a volume show.
#pragma once

#include "nodes/data/volume.h"
#include "nodes/section/section.h"

namespace terrazzo {

// The box that a volume's planes are measured in: one period, or the active voxels where it has none.
struct VolumeBox {
  Vec3 corner = Vec3::Zero();  // mm
  Vec3 size = Vec3::Zero();    // mm
  bool periodic = false;
  double voxel = 1;  // mm, the finest edge
};
// Throws Error "no-grids" or "empty-volume".
VolumeBox volume_box(const Volume&);

// Trilinear samples at pixel centres of `Cd`, or of `density` as grey. Labels: connected regions of equal
// `id` ≥ 0 (that which the voxels around hold most of; 4 neighbours), or of density ≥ ½ where there is no id.
// Profiles are those regions, area counted in pixels, without contours. The layout is relative to the box's
// corner. Throws Error "no-color" where there is neither Cd nor density.
struct VolumeSection : Section {
  std::string color_grid, label_grid;  // what was used; label_grid is empty where there was none
};
VolumeSection cut_volume(const Volume&, const SectionLayout&, const Work& = {});

}  // namespace terrazzo

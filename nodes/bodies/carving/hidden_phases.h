// Phases of a volume that are not shown, such as pores. They become holes of the carved body.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/work.h"

namespace terrazzo::carving {

// The voxels that ColorField holds.
struct HiddenVoxels {
  Vec3i size = Vec3i::Zero();
  bool periodic = true;
  std::vector<std::uint8_t> in;  // 1: hidden, x fastest
};

// Throws Error "no-such-grid" (no whole numbers in `phase`), "no-such-phase", "all-hidden", and those of
// voxel_box().
HiddenVoxels hidden_voxels(const Volume&, std::vector<std::int64_t> phases, const Work& = {});

// Peak memory in bytes of hidden_void() and of rendering it.
double hidden_forecast(const HiddenVoxels&, const Work&);

// A packing of one void, for `Voids`.
struct HiddenVoid {
  Particles particles;
  Shapes shapes;
  double voxel = 1;  // mm
  bool periodic = true;
  Vec3i size = Vec3i::Zero();
  std::vector<float> share;  // hidden part of what is around each voxel

  // Whether a point, in mm, is hidden. Interpolates between voxel centers.
  bool holds(const Vec3f& point) const;
};

// The surface between hidden voxels and the others, where the mean of the voxels around it, weighted 1 : 2 :
// 1 along each axis, is a half. It is open where a period ends and continues in the next. `voxel` in mm.
// Throws Error "no-surface".
HiddenVoid hidden_void(const HiddenVoxels&, double voxel, const Work&);

}  // namespace terrazzo::carving

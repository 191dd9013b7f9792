// New voxel values from the matched patches that overlap there.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/solid_optimize/cover.h"
#include "nodes/solid_optimize/search.h"

namespace terrazzo::solid_optimize {

struct BlendSettings {
  float window =
      0.1f;  // of the mean shift, in units of the exemplars' total standard deviation; 0: plain mean
};

// Where a voxel's value came from: the texel nearest to it among those of most weight.
struct BlendSources {
  std::vector<std::uint32_t> texel;    // per voxel
  std::vector<std::uint8_t> exemplar;  // per voxel
  std::vector<Vec3f> features;         // per voxel; empty where no exemplar has any
};

// Voxels lo … hi − 1 of a field, and the patches over each: of families whose slices are the field's planes.
struct BlendRange {
  std::array<const std::vector<PatchCover>*, 3> covers;  // per axis, of each voxel of the field
  Vec3i lo, hi;
};

// Each voxel becomes a mean of the texels that the patches over it show (16 a plane; Kopf et al. 2007, eq.
// 6). The planes count equally, the patches of a plane by their weights. A mean shift narrows the mean to the
// dominant cluster (Wexler et al. 2007), its window falling from the texels' own spread to `window`.
// `sources` and `features` (per exemplar and texel, may hold empty ones) may be null.
void blend_patches(const std::vector<const ExemplarLevel*>& exemplars, const std::vector<MatchFamily>&,
                   const BlendSettings&, SolidField&, BlendSources* sources,
                   const std::vector<const std::vector<Vec3f>*>* features, const Work&);
// The same in a part of a field alone.
void blend_patches(const std::vector<const ExemplarLevel*>& exemplars, const std::vector<MatchFamily>&,
                   const BlendSettings&, const BlendRange&, SolidField&, BlendSources* sources,
                   const std::vector<const std::vector<Vec3f>*>* features, const Work&);

}  // namespace terrazzo::solid_optimize

// New voxel values from the overlapping matched patches.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/solids/synthesis/matching/cover.h"
#include "nodes/solids/synthesis/matching/search.h"

namespace terrazzo::solids {

struct BlendOptions {
  float window =
      0.1f;  // of the mean shift, in units of the exemplars' total standard deviation; 0: plain mean
};

// The source of each voxel's value: of the texels with most weight, the one nearest to the value.
struct BlendSources {
  std::vector<std::uint32_t> texel;    // per voxel
  std::vector<std::uint8_t> exemplar;  // per voxel
  std::vector<Vec3f> features;         // per voxel; empty if no exemplar has features
};

// Voxels lo … hi − 1 of a field, and the patches over each voxel. The families' slices are the field's
// planes.
struct BlendRange {
  std::array<const std::vector<PatchCover>*, 3> covers;  // per axis, for each voxel of the field
  Vec3i lo, hi;
};

// Each voxel becomes a mean of the texels of the patches over it (16 per plane; Kopf et al. 2007, eq. 6).
// Planes have equal weight; a plane's patches have their own weights. A mean shift narrows the mean to the
// dominant cluster (Wexler et al. 2007); its window falls from the texels' own spread to `window`. `sources`
// and `features` may be null. `features` is indexed by exemplar and texel and may contain empty entries.
void blend_patches(const std::vector<const ExemplarLevel*>& exemplars, const std::vector<NeighborField>&,
                   const BlendOptions&, SolidField&, BlendSources* sources,
                   const std::vector<const std::vector<Vec3f>*>* features, const Work&);
// The same for part of a field.
void blend_patches(const std::vector<const ExemplarLevel*>& exemplars, const std::vector<NeighborField>&,
                   const BlendOptions&, const BlendRange&, SolidField&, BlendSources* sources,
                   const std::vector<const std::vector<Vec3f>*>* features, const Work&);

}  // namespace terrazzo::solids

// Descriptions of patches by their cosine transforms.
#pragma once

#include <array>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/solids/patch_fill/torus.h"
#include "runtime/work.h"

namespace terrazzo::patch_fill {

constexpr int kPatch = 8;  // edge of a patch, voxels

// The coefficients of the three-dimensional cosine transform (one for each channel) that vary most over the
// patches of two solids. The transform keeps distances, so that the distance of two descriptions is nearly
// that of the patches.
class PatchSpace {
 public:
  PatchSpace(const Torus<Vec3f>& a, const Torus<Vec3f>& b, int dimensions, std::uint64_t seed);

  int dimensions() const { return count_of(chosen_); }
  // The share of the patches' variance that the coefficients hold.
  double share() const { return share_; }
  // Descriptions of the patches that start at every `stride`-th voxel of each axis, x fastest.
  std::vector<float> describe(const Torus<Vec3f>&, int stride, const Work&) const;

 private:
  struct Coefficient {
    int channel, u, v, w;
  };
  std::vector<Coefficient> chosen_;  // sorted by channel, u, v, w
  double share_ = 0;
};

}  // namespace terrazzo::patch_fill

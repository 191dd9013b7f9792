// Classification of color clusters as particles or binder.
#pragma once

#include <string>
#include <vector>

#include "nodes/photograph/segment/color/clustering.h"
#include "nodes/photograph/segment/color/mosaic.h"

namespace terrazzo::segment {

struct Hint {
  // None: every pixel belongs to a particle.
  enum class Kind { Auto, Darkest, Lightest, Color, None } kind = Kind::Auto;
  Vec3f color = Vec3f::Zero();  // as from patch_color()
};

struct Ground {
  Clusters clusters;
  std::vector<bool> is_binder;  // by cluster
  double score = 0;  // of the choice: area of the particle pieces times how much they look like particles
  bool binder(const Vec3f& patch_color) const { return is_binder[clusters.nearest(patch_color)]; }
};

// Clusters the colors of the patches and finds the binder. `k` is the number of clusters; 0 selects the
// largest number up to 6 whose silhouette is at least 0.75 and within a tenth of the best. The binder is the
// set of clusters whose complement, split at its necks, consists of the most convex pieces with the largest
// share of outline on the binder. The set grows from the best single cluster (or the hinted one) as long as
// the score improves. So interstitial pores join the binder and round pores stay particles. Uneven light is
// removed from the mosaics. Throws Error "one-color" if there are fewer than two clusters.
Ground find_ground(std::vector<Mosaic>&, int k, const Hint&, double split, std::uint64_t seed, const Work&);

// Removes slow changes of light from sections where they are strong compared with the distances of the
// clusters' colors. Returns whether any changed.
bool even_light(std::vector<Mosaic>& sections, const Clusters&, const Work&);

}  // namespace terrazzo::segment

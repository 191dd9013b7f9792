// Which colour clusters are particles, and which the ground that they lie in.
#pragma once

#include <string>
#include <vector>

#include "nodes/segment/clustering.h"
#include "nodes/segment/regions.h"

namespace terrazzo {

struct Hint {
  enum class Kind { Auto, Darkest, Lightest, Color } kind = Kind::Auto;
  Vec3f color = Vec3f::Zero();  // patch colour
};

struct Ground {
  Clusters clusters;
  std::vector<bool> is_binder;  // by cluster
  double score = 0;  // of the choice: area of the particles' pieces times how far they look like particles
  bool binder(const Vec3f& patch_color) const { return is_binder[clusters.nearest(patch_color)]; }
};

// Clusters the patches' colours (k given, or 0: the most for which the silhouette stays within a tenth of its
// best and above .75, at most 6) and finds the binder: the set of clusters whose complement, parted at its
// necks, falls into the most convex pieces with the most of their outline on the binder. The set grows from
// the best single cluster (or the one hinted at) as long as that helps: so interstitial pores join the
// binder, round ones stay particles. Throws Error "one-colour" where there are no two colours.
Ground find_ground(std::vector<Mosaic>&, int k, const Hint&, double split, bool even_light,
                   std::uint64_t seed, const Work&);

}  // namespace terrazzo

// Tree of all regions that patches merge into, and the choice of those that look like particles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/segment/regions.h"

namespace terrazzo::segment {

// Statistics of a region. All are sums, so those of a merged region follow from its parts.
struct Candidate {
  int parent = -1, left = -1, right = -1;                 // left and right are −1 in a leaf
  double area = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;  // pixels, and moments of their positions
  double gradient = 0;                                    // sum over the pixels
  Eigen::Vector3d color = Eigen::Vector3d::Zero();        // sum over the pixels
  double color_square = 0;
  double border = 0, border_gradient = 0, border_closed = 0,
         border_light = 0;  // sums over pixel edges to other regions
  double around = 0;        // mean color difference to the neighbors at the time of the merge

  // 1 for an ellipse, otherwise less: the area divided by that of the ellipse with the same second moments.
  double ellipticity() const;
};

struct RegionTree {
  std::vector<std::int32_t> leaf;     // candidate index of each pixel
  std::vector<Candidate> candidates;  // parts before wholes
  double usual_gradient = 0;          // median over the pixels
};

// Merges neighbors until one region is left. Pairs merge first if their shared border is weak and long for
// their sizes and their union is compact: a binary partition tree (Salembier and Garrido 2000) guided by
// shape as well as color.
RegionTree build_region_tree(const Mosaic&, const Work&);

// Probability-like score from 0 to 1 that a candidate is a particle: a logistic function of five
// dimensionless features. These are its ellipticity, the gradient at its border relative to that inside, the
// share of the border with a clear edge, the color difference across the border relative to the image's usual
// gradient, and the darkness of the border. The weights were fitted to hand-made masks of pebbles in four
// photographs, which are not needed at run time.
double particle_likeness(const Candidate&, const RegionTree&);

// Selection criteria.
struct Choice {
  double threshold = 0.2;                 // regions with a lower likeness are not particles
  double min_area = 25, max_area = 1e12;  // pixels
  const Vec3f* binder = nullptr;          // patch color; regions of about this color are less likely
  float tolerance = 0.1f;                 // of that color
};

// The disjoint candidates with the largest sum of (likeness − threshold), found exactly from the leaves up.
// Labels start at 1.
std::vector<std::int32_t> choose_particles(const RegionTree&, const Choice&);

}  // namespace terrazzo::segment

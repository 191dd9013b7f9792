// All the regions that patches can merge into, and which of them look like particles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/segment/regions.h"

namespace terrazzo {

// What is known of a region when it is judged. Sums, so that a merged region's follow from those of its
// parts.
struct Candidate {
  int parent = -1, left = -1, right = -1;                 // left and right are −1 in a leaf
  double area = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;  // pixels and moments of their places
  double gradient = 0;                                    // sum over the pixels
  Eigen::Vector3d color = Eigen::Vector3d::Zero();        // sum over the pixels
  double color_square = 0;
  double border = 0, border_gradient = 0, border_closed = 0,
         border_light = 0;  // over pixel edges to other regions
  double around = 0;        // mean colour difference to the regions around when it came to be

  // 1 for an ellipse, less for anything else: area over that of the ellipse of the same second moments.
  double ellipticity() const;
};

struct RegionTree {
  std::vector<std::int32_t> leaf;     // of each pixel: candidate index
  std::vector<Candidate> candidates;  // parts before wholes
  double usual_gradient = 0;          // median over the pixels
};

// Merges neighbours until one region is left, first those whose shared border is weak, long for their sizes,
// and whose union is compact: a binary partition tree (Salembier and Garrido 2000) that follows shape as well
// as colour.
RegionTree build_region_tree(const Mosaic&, const Work&);

// How much a candidate looks like a particle, 0…1: a logistic function of five numbers without scale. They
// are its ellipticity; the gradient along its border against that inside; how much of the border is a clear
// edge; the colour difference across it against the picture's usual gradient and against the spread inside;
// and how dark the border is. The weights were fitted to hand-made masks of pebbles in four photographs, none
// of which is needed to use them.
double particle_likeness(const Candidate&, const RegionTree&);

// Which candidates to take, and how readily.
struct Choice {
  double threshold = 0.2;                 // likeness below which a region is no particle
  double min_area = 25, max_area = 1e12;  // pixels
  const Vec3f* binder = nullptr;          // patch colour: regions of about this colour are less likely
  float tolerance = 0.1f;                 // of that colour
};

// The disjoint candidates with the largest sum of (likeness − threshold), found exactly from the leaves up.
// Labels from 1.
std::vector<std::int32_t> choose_particles(const RegionTree&, const Choice&);

}  // namespace terrazzo

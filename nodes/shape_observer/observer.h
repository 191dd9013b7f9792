// A linear classifier that tells views of one population of shapes from views of another.
#pragma once

#include <cstdint>
#include <string>

#include "nodes/common/random_sections.h"
#include "runtime/work.h"

namespace terrazzo::shape_observer {

struct ObserverChoice {
  int profiles = 20;  // that a view shows
  int views = 180;    // of each population
  std::uint64_t seed = 1;
  int points = 128;  // at which outlines are measured
  // How well the observer sees, in units of what is just visible in a small picture: each measure of each
  // profile is read with a normal error of that (0.0012 of area/perimeter², 0.12 rad of total curvature, 0.03
  // of aspect, 0.006 of convexity, 4 degrees of corners and so on, as feature_match.h has them). 0: exactly,
  // down to the triangles of a mesh.
  double eyesight = 1;
};

struct Verdict {
  double told = 0;   // share of pairs in which the decoy was found, 0…1
  double error = 0;  // standard error of it, of as many pairs as views
  std::string by;    // the feature whose means differ most, in units of a view's standard deviation
};

// Nine-fold cross-validation of Fisher's discriminant with the pooled covariance shrunk by a tenth towards
// its diagonal. Views of both are drawn alike from random sections, the decoy's of other planes.
Verdict observe(const Shapes& original, const Shapes& decoy, const ObserverChoice&, const Work& = {});

}  // namespace terrazzo::shape_observer

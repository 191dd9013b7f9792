// A linear classifier that distinguishes views of one population of shapes from views of another.
#pragma once

#include <cstdint>
#include <string>

#include "nodes/common/stereology/random_sections.h"
#include "runtime/work.h"

namespace terrazzo::shape_observer {

struct ObserverOptions {
  int profiles = 20;  // number per view
  int views = 180;    // number per population
  std::uint64_t seed = 1;
  int points = 128;  // number of points at which outlines are measured
  // Reading error in units of what is just visible in a small image. Each measure of each profile has a
  // normal error with this factor times 0.0012 for area/perimeter², 0.12 rad for total curvature, 0.03 for
  // aspect ratio, 0.006 for convexity, 4 degrees for corners, and so on, as in feature_match.h. 0: exact,
  // down to the triangles of a mesh.
  double eyesight = 1;
};

struct Verdict {
  double told = 0;   // classification accuracy: share of pairs in which the decoy was identified, 0…1
  double error = 0;  // standard error of `told`, with as many pairs as views
  std::string by;    // the feature whose means differ most, in units of the views' standard deviation
};

// Nine-fold cross-validation of Fisher's discriminant with the pooled covariance shrunk by a tenth towards
// its diagonal. Views of both are drawn in the same way from random sections; the planes of the decoy differ.
Verdict observe(const Shapes& original, const Shapes& decoy, const ObserverOptions&, const Work& = {});

}  // namespace terrazzo::shape_observer

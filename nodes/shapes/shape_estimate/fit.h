// Our own fifth method: bodies whose random sections are distributed like all the profiles, not
// just three of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shapes/shape_estimate/outline.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct FitRequest {
  // Groups of profiles from which other methods build starting bodies.
  std::vector<std::vector<Outline>> hands;
  const std::vector<Outline>* all = nullptr;
  int count = 3;          // number of bodies
  double smallest = 0.4;  // as in CandidateOptions, for sections of the bodies
  bool one_size = false;  // the particles are known to have one size: areas are compared too
  // The outlines are silhouettes of stones that lie flat, seen from above. Bodies lie with z upright, and
  // their height, which the outlines don't show, is `thickness` times the shorter axis of their silhouette.
  bool from_above = false;
  double thickness = 1;
  int rounds = 3;  // rounds of the search for each body
  int subdivision = 1;
  // Sections of each trial; 0: the number of profiles, at least 144, and at most 85 per round or 512.
  std::size_t planes = 0;
  std::uint64_t seed = 1;
};

struct FittedBody {
  Mesh mesh;               // mm
  double probability = 1;  // by number
  bool smooth = false;     // not a polyhedron
  std::string from;        // the method of its starting body
};

struct Fit {
  std::vector<FittedBody> bodies;
  double start = 0;     // distance of the best starting body from the observed profiles (feature_match.h)
  double distance = 0;  // distance of the mixture of bodies
};

// Each body starts from one of the best bodies that cylinders and spherical harmonics build from the hands,
// from a modeled body or from a polyhedron. Least squares deforms it (body_family.h) until its sections,
// together with those of the previous bodies, are distributed like the profiles in circularity, total
// curvature, aspect ratio, convexity, corners, symmetry, curvature and inscribed polygons, individually and
// jointly (feature_match.h). Shares then follow from the distribution functions by least squares. Bodies with
// a share below 0.1 % are dropped. Throws Error "no-start" if no method can build a body.
Fit fit_bodies(const FitRequest&, const Work& = {});

}  // namespace terrazzo::shape_estimate

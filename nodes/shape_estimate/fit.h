// Our own fifth method: bodies whose random sections look like all the profiles, not like three of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nodes/data/shapes.h"
#include "nodes/shape_estimate/outline.h"
#include "runtime/work.h"

namespace terrazzo::shape_estimate {

struct FitRequest {
  std::vector<std::vector<Outline>> hands;  // profiles that the other methods make starting bodies of
  const std::vector<Outline>* all = nullptr;
  int count = 3;          // bodies
  double smallest = 0.4;  // as in CandidateOptions: sections of the bodies are left out as observed ones were
  bool one_size = false;  // the particles are known to be of one size: areas count too
  int rounds = 8;         // of the search for each body
  int subdivision = 1;
  std::size_t planes = 0;  // sections of each trial; 0: as many as profiles, 192 to 512
  std::uint64_t seed = 1;
};

struct FittedBody {
  Mesh mesh;               // mm
  double probability = 1;  // by number
  bool smooth = false;     // without planes
  std::string from;        // the method of its starting body
};

struct Fit {
  std::vector<FittedBody> bodies;
  double start = 0;     // distance of the best starting body to the observed profiles (feature_match.h)
  double distance = 0;  // of the bodies together
};

// Each body starts from one of the best of what the other four methods make of the hands (the first from the
// best, the next from another), is deformed (body_family.h) by least squares until the sections of it and of
// those before it together are distributed like the profiles, in circularity, total curvature, aspect ratio,
// convexity, corners, symmetry and curvature, alone and jointly (feature_match.h). Shares then follow from
// the distribution functions by least squares. Throws Error "no-start" where no method makes a body.
Fit fit_bodies(const FitRequest&, const Work& = {});

}  // namespace terrazzo::shape_estimate

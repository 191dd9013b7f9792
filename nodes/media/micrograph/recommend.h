// Whether a picture is better taken for particles or for phases.
#pragma once

#include <string>

#include "nodes/data/image.h"
#include "nodes/media/micrograph/phase_map.h"
#include "runtime/work.h"

namespace terrazzo::media {

// How compact the most compact phase is, 0 … 1: the share that its pieces fill of their convex hulls,
// weighted by their areas. Phases of which one piece has more than nine tenths surround the others and do not
// count.
double compactness(const PhaseMap&);

struct Recommendation {
  bool phases = false;  // else particles
  std::string why;      // a sentence
};

// Looks at the middle of the first section. Particles if the picture has one gray level, or if a phase
// consists of compact pieces.
Recommendation recommend(const Image&, const Work&);

}  // namespace terrazzo::media

// Chooses how particles of a given density are packed.
#pragma once

#include <string>

#include "nodes/packing/packing.h"

namespace terrazzo::pack {

enum class Method { Auto, Anneal, Grow, Laguerre };

struct Choice {
  Method method = Method::Anneal;  // not Auto
  packing::PackResult packed;      // with method Anneal
  std::string reason;              // a sentence
};

// Without a binder (a volume fraction of 0.97 or more): Laguerre. Where the particles can be packed: Anneal,
// and the packing, which continues from `start` (may be null). Otherwise: Grow. Of the options, only
// population and interrupted count. Throws the errors of pack_particles() except "jammed".
Choice choose_method(const SizeDistribution& distribution, const Shapes& shapes, const Particles* start,
                     const packing::PackOptions& options, const Work& work);

}  // namespace terrazzo::pack

// Particle colors, drawn from the profiles in a photograph.
#pragma once

#include <cstdint>
#include <string>

#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo::colorize {

enum class ColorMode {
  Random,  // any profile by its weight: unbiased if color does not depend on size
  BySize,  // a profile, by the probability that a particle of this size shows it (colors_of_sizes.h)
  Classes  // a profile of the particle's own class
};

struct ColorOptions {
  ColorMode mode = ColorMode::Random;
  std::uint64_t seed = 1;
  int clusters = 0;  // number of classes if neither particles nor profiles have any; 0: by silhouette
};

struct ColorReport {
  std::size_t profiles_used = 0;  // those with a weight
  int clusters = 0;               // found by k-means; 0 if none were needed
  double silhouette = 0;
  double hidden = 0;        // the fragments' share of the area
  bool weightless = false;  // every profile touches the border, so all have equal weight
  bool colorless = false;   // every profile is black, as from a table of areas
};

// Sets color and binder_color. In modes Random and BySize, as many particles as the fragments' share of the
// area have the color of a fragment, if that is at least 0.4 times as wide as they are. In mode BySize,
// particles of several classes get colors of profiles of their own class, if these have several classes too.
// In mode Classes, if all particles have the same class, also sets cls: the profiles' classes (found by
// k-means in Oklab if they have none either) are drawn by size. Jagnow et al. 2004, section 4.2. Throws Error
// "no-profiles", "bad-profile" (NaN, no area), "no-class" (no profile has a particle's class).
ColorReport colorize(Particles&, const Profiles&, const ColorOptions&, const Work& = {});

}  // namespace terrazzo::colorize

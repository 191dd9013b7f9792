// Colours of particles, drawn from the profiles that a photograph shows.
#pragma once

#include <cstdint>
#include <string>

#include "nodes/data/particles.h"
#include "nodes/data/profiles.h"
#include "runtime/work.h"

namespace terrazzo {

enum class ColorMode {
  Random,  // any profile by its weight: unbiased where colour does not depend on size
  BySize,  // a profile that a sphere of the particle's size would show, by its probability
  Classes  // a profile of the particle's own class
};

struct ColorChoice {
  ColorMode mode = ColorMode::Random;
  std::uint64_t seed = 1;
  int clusters = 0;  // of Classes where the particles have none; 0: by silhouette
};

struct ColorReport {
  std::size_t profiles_used = 0;  // with a weight
  int clusters = 0;               // found by k-means; 0 where none were needed
  double silhouette = 0;
  bool weightless = false;  // every profile touches the border: all counted alike
  bool colorless = false;   // every profile is black, as from a table of areas
};

// Sets color and binder_color; and cls, where mode is Classes and the particles have one class only: then the
// profiles' classes (k-means in Oklab where these have none either) are drawn by size. Jagnow et al. 2004,
// section 4.2. Throws Error "no-profiles", "bad-profile" (NaN, no area), "no-class" (a particle's class that
// no profile has).
ColorReport colorize(Particles&, const Profiles&, const ColorChoice&, const Work& = {});

// The probability that a random section of a sphere of diameter `size` that meets it has a diameter within ±5
// % of `size` around `profile`; 0 where no section is so large.
double profile_likelihood(double profile, double size);

}  // namespace terrazzo

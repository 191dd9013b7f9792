// Which colors particles of each size have, estimated from the sizes and colors of profiles.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/linear.h"
#include "runtime/work.h"

namespace terrazzo::colorize {

// The probability that a random section that meets a sphere of diameter `size` has a diameter within ±5 % of
// `size` around `profile`; 0 if no section is that large.
double profile_likelihood(double profile, double size);

struct ColoredProfile {
  double size, weight;  // size: √(4A/π)
  Vec3f color;          // scene-linear
};

// A profile may come from any particle that is large enough. The weight of a profile for a particle is the
// probability that this particle shows it, among all particles that could (Bayes); a profile counts less the
// smaller it is compared with the particle. The probability depends on the colors that particles of each size
// have, which are estimated by maximum likelihood (EM, as Richardson 1972 and Lucy 1974), so small profiles
// of a color that large profiles lack come from small particles.
class ColorsOfSizes {
 public:
  // `sizes`: of all particles, positive. Colors within 16 clusters (k-means in Oklab) are equal here.
  ColorsOfSizes(const std::vector<ColoredProfile>& profiles, const std::vector<double>& sizes,
                std::uint64_t seed, const Work&);

  // 0 if the particle cannot show the profile. Of one particle, only ratios of weights have a meaning.
  double weight(std::size_t profile, double size) const;

 private:
  std::size_t bin_of(double size) const;

  std::vector<ColoredProfile> profiles_;
  std::vector<int> cluster_;      // of each profile
  std::vector<double> expected_;  // by profile: Σ over the particles of likelihood · share of the color
  double smallest_ = 1, ratio_ = 1;
  std::vector<std::vector<double>> share_;  // [bin of sizes][cluster]
};

}  // namespace terrazzo::colorize

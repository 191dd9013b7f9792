// Ideal observations: what planes through particles of known sizes show, without a border or a picture.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/kmatrix.h"
#include "nodes/data/profiles.h"
#include "nodes/data/size_distribution.h"
#include "runtime/work.h"

namespace terrazzo::unfold_study {

// Particles per volume below a size, from a distribution whose classes are each uniform; shapes and colour
// classes taken together.
class TrueSizes {
 public:
  // Throws Error "no-sizes" where there are no particles.
  explicit TrueSizes(const SizeDistribution&);
  double total() const { return total_; }  // per mm³
  double between(double low, double high) const;
  double largest() const { return edges_.back(); }
  const std::vector<double>& edges() const { return edges_; }
  const std::vector<double>& density() const { return N_V_; }  // per mm³ and class

 private:
  std::vector<double> edges_, N_V_;
  double total_ = 0;
};

// Draws profiles as isotropic uniform random planes see them: a particle with a chance proportional to its
// caliper, its profile's area from the K matrix's distribution; shapes by their probabilities. The number of
// profiles is Poisson, as that of particles placed without regard to each other.
class ProfileSampler {
 public:
  ProfileSampler(const TrueSizes&, const KMatrix&);
  // Of the area in which `expected` profiles are to be expected. Section s of `sections` by profile number.
  Profiles sample(double expected, int sections, std::uint64_t seed, std::uint64_t repetition,
                  const Work&) const;

 private:
  struct Source {            // one shape at one class of sizes
    double low, high, seen;  // mm; profiles per mm² from here, cumulative
    std::size_t shape;
  };
  const KMatrix& k_;
  std::vector<Source> sources_;
  std::vector<std::vector<double>> quantiles_;  // of √(A/A_max), a shape each
};

}  // namespace terrazzo::unfold_study

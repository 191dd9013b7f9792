// Ideal observations: profiles of planes through particles of known sizes, without a border or a photograph.
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/data/kmatrix.h"
#include "nodes/data/profiles.h"
#include "nodes/data/size_distribution.h"
#include "runtime/work.h"

namespace terrazzo::unfold_study {

// Number densities of a distribution whose sizes are uniform within each class, over all
// shapes and color classes.
class TrueSizes {
 public:
  // Throws Error "no-sizes" if there are no particles.
  explicit TrueSizes(const SizeDistribution&);
  double total() const { return total_; }         // per mm³
  double between(double low, double high) const;  // per mm³, of sizes in mm
  // Share of all profiles that particles of these sizes show: planes meet them in proportion to their size.
  double profiles_between(double low, double high) const;
  double largest() const { return edges_.back(); }
  const std::vector<double>& edges() const { return edges_; }
  const std::vector<double>& density() const { return N_V_; }  // per mm³ and class

 private:
  std::vector<double> edges_, N_V_;
  double total_ = 0;
};

// Draws profiles as isotropic uniform random planes show them. The probability of a particle is proportional
// to its caliper; the area of its profile comes from the K matrix's distribution; shapes are drawn by their
// probabilities. The number of profiles is Poisson distributed, as for particles placed independently.
class ProfileSampler {
 public:
  ProfileSampler(const TrueSizes&, const KMatrix&);
  // Draws profiles in the area where `expected` profiles are expected. Profile i is in
  // section i mod `sections`.
  Profiles sample(double expected, int sections, std::uint64_t seed, std::uint64_t repetition,
                  const Work&) const;

 private:
  struct Source {            // one shape in one size class
    double low, high, seen;  // size in mm; cumulative number of profiles per mm²
    std::size_t shape;
  };
  const KMatrix& k_;
  std::vector<Source> sources_;
  std::vector<std::vector<double>> quantiles_;  // of √(A/A_max), per shape
};

}  // namespace terrazzo::unfold_study

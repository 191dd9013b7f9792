// The spherical deformation model of Hobolth and Jensen (2002; Jagnow et al. 2008, section 3.1): a sphere
// whose radius is a Gaussian random function of direction.
#pragma once

#include <vector>

#include "nodes/shapes/shape_estimate/outline.h"

namespace terrazzo::shape_estimate {

inline constexpr int kHarmonicTerms = 30;

struct ProfileSpectrum {
  double radius = 0;  // mean of the profiles' mean radii, mm
  // κ_m: mean of ((b_m^s)² + (b_m^c)²)/2 over the profiles scaled to b_0 = √2π; it is a variance
  // (errata 6 in docs/errata.md).
  std::vector<double> variance;
};
// Profiles are sampled as radii of 256 rays at their outermost crossings. Throws Error "no-crossing" if no
// inner center can be found.
ProfileSpectrum profile_spectrum(const std::vector<Outline>&, int terms);

// c_n of κ_m = Σ c_n λ_n: (2n+1)/2 (n−m)!/(n+m)! P_n^m(0)².
std::vector<double> equator_weights(int m, int terms);

// The λ_n ≥ 0, n ≥ 2, for which the variances of central sections are closest to κ.
std::vector<double> harmonic_variances(const std::vector<double>& kappa);

}  // namespace terrazzo::shape_estimate

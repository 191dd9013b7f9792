// The spherical deformation model of Hobolth and Jensen (2002; 2008, 3.1): a sphere whose radius is a
// Gaussian random function of the direction.
#pragma once

#include <vector>

#include "nodes/shape_estimate/outline.h"

namespace terrazzo::shape_estimate {

inline constexpr int kHarmonicTerms = 30;

struct ProfileSpectrum {
  double radius = 0;  // mean of the profiles' mean radii, mm
  // κ_m: mean of ((b_m^s)² + (b_m^c)²)/2 of the profiles scaled to b_0 = √2π (ERRATA: a variance).
  std::vector<double> variance;
};
// Profiles as radii of 256 rays, at their outermost crossings. Throws Error "no-crossing" where a centre
// cannot be found inside.
ProfileSpectrum profile_spectrum(const std::vector<Outline>&, int terms);

// c_n of κ_m = Σ c_n λ_n: (2n+1)/2 (n−m)!/(n+m)! P_n^m(0)².
std::vector<double> equator_weights(int m, int terms);

// λ_n ≥ 0, n ≥ 2, whose central sections have variances nearest to κ.
std::vector<double> harmonic_variances(const std::vector<double>& kappa);

}  // namespace terrazzo::shape_estimate

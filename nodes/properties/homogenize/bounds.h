// Bounds of effective properties from the fractions of the phases.
#pragma once

#include <vector>

#include "nodes/properties/homogenize/elasticity.h"

namespace terrazzo::homogenize {

struct Bounds {
  double low = 0, high = 0;
};

// For any arrangement: layers across and along the flow (Wiener 1912).
Bounds wiener_bounds(const std::vector<double>& fraction, const std::vector<double>& values);
// For isotropic ones (Hashin and Shtrikman 1962).
Bounds hashin_shtrikman(const std::vector<double>& fraction, const std::vector<double>& values);

struct ElasticBounds {
  Bounds bulk, shear;
};
// For isotropic arrangements (Hashin and Shtrikman 1963, for any number of phases as in Berryman 1995).
ElasticBounds hashin_shtrikman(const std::vector<double>& fraction, const std::vector<Elastic>& values);

// The isotropic material nearest to a stiffness (Voigt averages over all directions).
struct Moduli {
  double bulk = 0, shear = 0;
  double young() const { return bulk + shear > 0 ? 9 * bulk * shear / (3 * bulk + shear) : 0; }
  double poisson() const { return bulk + shear > 0 ? (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear)) : 0; }
};
Moduli isotropic_part(const Stiffness&);

}  // namespace terrazzo::homogenize

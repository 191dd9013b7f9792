// Trilinear finite elements on cubic voxels, for two loads at a time.
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "nodes/properties/homogenize/elasticity.h"

namespace terrazzo::homogenize {

// Of the voxels' lower corners, by component. The real part belongs to one load, the imaginary part to
// another.
using Displacements = std::array<std::vector<std::complex<float>>, 3>;
Displacements zero_displacements(std::size_t count);

using PerLoad = std::array<double, 2>;
using Strains = std::array<std::array<double, 6>, 2>;  // or stresses, by load, in Voigt's order

class Elements {
 public:
  // Stiffness relative to a Young's modulus of `unit`.
  Elements(const PhaseMap&, const std::vector<Elastic>&, double unit);

  // force = the nodes' forces for displacements u and the mean strains `mean` (null: none). Returns the mean
  // stresses. `mises`: set to the von Mises stress of the first load at the elements' centers.
  Strains apply(const Displacements& u, const Strains* mean, Displacements& force, const Work&,
                std::vector<float>* mises = nullptr) const;

 private:
  struct Rows;
  void gather(const Displacements&, int y, int z, Rows&) const;
  void load_moduli(int y, int z, Rows&) const;
  static void find_forces(Rows&);
  void scatter(Rows&, int y, int z, Displacements&) const;
  void add_stresses(const Rows&, Strains&, float* mises) const;

  Vec3i size_;
  const std::vector<std::uint8_t>& phase_;
  std::vector<float> lambda_, mu_;  // by phase
};

}  // namespace terrazzo::homogenize

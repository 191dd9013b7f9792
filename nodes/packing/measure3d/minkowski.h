// Densities of the Minkowski functionals of phases, from the voxels around each corner of a voxel.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "nodes/packing/measure3d/classes.h"

namespace terrazzo::measure3d {

// Numbers of cubes of 2 × 2 × 2 voxels by which of these are in a class: bit dx + 2·dy + 4·dz. Periodic
// volumes have as many cubes as voxels, others those inside the box.
using Cubes = std::array<std::uint64_t, 256>;
std::vector<Cubes> count_cubes(const Classes&, const Work&);

// Per volume. NaN if the box has no cube.
struct MinkowskiDensities {
  double surface = NAN;    // 1/mm
  double curvature = NAN;  // integral of the mean curvature (k1 + k2)/2, 1/mm²; negative where hollow
  double euler = NAN;      // Euler number, 1/mm³
};

// From a class's cubes (Ohser and Mücklich 2000, chapter 4). Every density is a mean over cubes, so it has no
// bias from the border of volumes that do not tile.
// Surface: Crofton's formula with the 13 directions to the 26 neighbors, as in voxel_surfaces().
// Curvature: 2π · mean of the Euler number per area of plane sections, with the planes of voxels normal to 13
// directions. In square and rectangular lattices of voxels the mean of 4 and 8 neighbors is taken, in
// triangular ones 6. So the phase and the rest differ only in sign.
// Euler number: of the union of closed voxels (26 neighbors), or with `faces_only` of that of open voxels
// (6). That of the phase with one and that of the rest with the other are equal in periodic volumes.
// Where bodies overlap in creases, as in Boolean models, both this and the curvature differ from those of the
// bodies at any resolution (Ohser, Nagel and Schladitz 2003).
MinkowskiDensities minkowski_densities(const Cubes&, const Vec3& spacing, bool faces_only);

}  // namespace terrazzo::measure3d

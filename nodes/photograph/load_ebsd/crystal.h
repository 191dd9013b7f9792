// Crystal symmetry: Laue groups, disorientation, and colors of directions.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::load_ebsd {

// In the order of the numbers 1 to 11 in .ctf files.
enum class LaueGroup {
  Triclinic,       // -1
  Monoclinic,      // 2/m, the axis of the text that follows
  Orthorhombic,    // mmm
  TetragonalLow,   // 4/m
  TetragonalHigh,  // 4/mmm
  TrigonalLow,     // -3
  TrigonalHigh,    // -3m
  HexagonalLow,    // 6/m
  HexagonalHigh,   // 6/mmm
  CubicLow,        // m-3
  CubicHigh,       // m-3m
};
const char* name_of(LaueGroup);

struct Symmetry {
  LaueGroup group = LaueGroup::Triclinic;
  int unique_axis = 1;  // of Monoclinic: 0, 1, 2 for a, b, c

  // The rotations that map the crystal to itself, the identity first: 1 to 24 unit quaternions.
  std::vector<Eigen::Quaternionf> rotations() const;
};

// Orientation of a crystal from Bunge's Euler angles in radians: the rotation that turns an object from the
// axes of the sample to the crystal's.
Eigen::Quaternionf from_bunge(double phi1, double Phi, double phi2);
// Back to angles in degrees: phi1 and phi2 in [0, 360), Phi in [0, 180].
Vec3 to_bunge(const Eigen::Quaternionf&);

// Cosine of half the disorientation: the smallest angle of a rotation from one crystal to the other, over
// all equivalent orientations.
float half_angle_cosine(const Eigen::Quaternionf& a, const Eigen::Quaternionf& b,
                        const std::vector<Eigen::Quaternionf>& rotations);

// The orientation equivalent to q that is closest to `reference`.
Eigen::Quaternionf closest(const Eigen::Quaternionf& q, const Eigen::Quaternionf& reference,
                           const std::vector<Eigen::Quaternionf>& rotations);

// The color, sRGB-encoded, of the crystal direction that is normal to the map. Equivalent orientations have
// equal colors. Cubic crystals: red for [001], green for [101], blue for [111]. Others: red for the c axis;
// around it, green and blue at the two borders of the sector that symmetry repeats.
Vec3f direction_color(const Eigen::Quaternionf&, const Symmetry&);

}  // namespace terrazzo::load_ebsd

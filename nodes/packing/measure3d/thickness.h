// Local thickness of phases, and with it their granulometry.
#pragma once

#include <cmath>
#include <vector>

#include "nodes/packing/measure3d/classes.h"

namespace terrazzo::measure3d {

// Diameter in mm of the largest ball inside its voxel's class that contains the voxel (Hildebrand and
// Rüegsegger 1997). As in PoreSpy and BoneJ, balls have their centers at voxel centers and reach to the
// nearest center of a voxel outside, exclusive: a plate of 2k − 1 voxels and one of 2k both measure 2k
// voxels. 0 where the class is not wanted, or has no surface. Periodic volumes wrap; the border of others
// bounds no ball. Throws Error "too-large" beyond `memory` bytes.
//
// Only balls that no ball at one of the 26 neighbors contains are drawn, by decreasing size, and each voxel
// is drawn once (Remy and Thiel 2005 find such balls by tables, too).
std::vector<float> local_thickness(const Classes&, std::uint64_t memory, const Work&);

// Of the voxels of one class. NaN and empty if its thickness is not known.
struct ThicknessDistribution {
  double mean = NAN, deviation = NAN;  // mm
  // Shares of the volume by thickness, mm; n + 1 and n. The share up to a diameter d is the share that an
  // opening by balls of diameter d removes: the granulometry by balls (Matheron 1975).
  std::vector<double> edges, share;
};

// By class, from local_thickness().
std::vector<ThicknessDistribution> thickness_distributions(const Classes&, const std::vector<float>& diameter,
                                                           const Work&);

}  // namespace terrazzo::measure3d

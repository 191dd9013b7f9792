// Fabric: the directions in which stones lie.
#pragma once

#include <vector>

#include "nodes/data/profiles.h"

namespace terrazzo::pack {

// The directions of the long axes of a surface's stones, radians from the picture's x axis, of those that are
// clearly longer than wide and not cut by the border. Empty if all directions are as likely as not
// (Rayleigh's test of the doubled angles at 0.001).
std::vector<double> long_axes(const Profiles&);

}  // namespace terrazzo::pack

// Which grid of a volume a node reads.
#pragma once

#include <string>
#include <vector>

#include "nodes/data/opaque_volume.h"

namespace terrazzo {

// `name`, or if that is empty the first of the usual ones that the volume has, else the only one. Throws
// Error "no-such-grid", "several-grids", with the parameter `grid`.
std::string grid_to_read(const Volume&, const std::string& name, const std::vector<std::string>& usual);

}  // namespace terrazzo

// Conversion from the cells of Voro++ (Rycroft 2009).
#pragma once

#include <voro++/voro++.hh>

#include "nodes/packing/cells/convex_cell.h"

namespace terrazzo::tessellation {

// `unit`: length in mm of a unit of the cell.
ConvexCell convert(voro::voronoicell_neighbor& cell, double unit);

}  // namespace terrazzo::tessellation

// Pixels inside of loops.
#pragma once

#include <functional>
#include <vector>

#include "nodes/common/geometry/mesh/loop.h"

namespace terrazzo {

// Calls `row(y, begin, end)` for each run of pixels whose centers lie inside an odd number of the loops, in
// reading order. Coordinates are pixels, (0, 0) is the corner of the first one. Only pixels of a picture of
// width × height are visited.
void fill_loops(const std::vector<Loop>&, int width, int height,
                const std::function<void(int y, int begin, int end)>& row);

}  // namespace terrazzo

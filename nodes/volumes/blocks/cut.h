// How a solid is cut into blocks.
#pragma once

#include <vector>

#include "nodes/data/linear.h"

namespace terrazzo::blocks {

// The part of a solid that a volume covers, in voxels.
struct Box {
  Vec3i low = Vec3i::Zero(), size = Vec3i::Zero();
};

// The box of all voxels of the blocks. Throws Error "missing-blocks", "overlapping-blocks" or
// "unequal-blocks" unless planes through the whole box cut it into exactly these blocks. Messages count
// blocks from 0.
Box box_of(const std::vector<Box>& blocks);

}  // namespace terrazzo::blocks

// Joins the blocks of a cut solid.
#pragma once

#include <vector>

#include "nodes/data/opaque_volume.h"
#include "runtime/work.h"

namespace terrazzo::join_volumes {

// The part of a solid that a volume covers, in voxels.
struct Box {
  Vec3i low = Vec3i::Zero(), size = Vec3i::Zero();
};

// The box of all voxels of the blocks. Throws Error "missing-blocks", "overlapping-blocks" or
// "unequal-blocks" unless planes through the whole box cut it into exactly these blocks. Messages count
// blocks from 0.
Box box_of(const std::vector<Box>& blocks);

// The boxes of volumes whose grids have a value in every voxel of one box. Throws Error "not-a-block" if a
// volume is not of this kind, and "unequal-blocks" if its grids differ from those of the first in name,
// type, transform or background.
std::vector<Box> boxes_of(const std::vector<const Volume*>&, const Work&);

// The bytes that the joined grids take in memory.
double joined_bytes(const std::vector<const Volume*>&);

// Copies all voxels into one volume. The volumes passed boxes_of(), and their boxes do not overlap.
// `resolution` of the result is zero.
Volume joined(const std::vector<const Volume*>&, const Work&);

}  // namespace terrazzo::join_volumes

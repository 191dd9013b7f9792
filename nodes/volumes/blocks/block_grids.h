// The blocks of a solid, looked at one after the other, so that they need not be in memory together.
#pragma once

#include <vector>

#include "nodes/data/grids.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/volumes/blocks/cut.h"

namespace terrazzo::blocks {

// A grid of the same type, metadata, transform and background, without voxels. Throws Error
// "unsupported-grid".
openvdb::GridBase::Ptr empty_like(const openvdb::GridBase&);

class BlockGrids {
 public:
  // `count`: the number of blocks that follow.
  explicit BlockGrids(std::size_t count) : count_(count) {}

  // Takes note of the next block and returns its box. Throws Error "not-a-block" unless the grids have a
  // value in every voxel of one box, and "unequal-blocks" if they differ from those of the first block in
  // name, type, transform or background.
  const Box& add(const Volume& block);
  const std::vector<Box>& boxes() const { return boxes_; }

  // The box of the solid. `periodic`: it must begin at voxel (0, 0, 0). Throws the errors of box_of().
  Box whole(bool periodic) const;

 private:
  std::size_t count_;
  Volume first_;  // its grids without their voxels
  std::vector<Box> boxes_;
};

}  // namespace terrazzo::blocks

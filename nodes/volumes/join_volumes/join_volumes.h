// Joins the blocks of a cut solid, one after the other.
#pragma once

#include <vector>

#include "nodes/data/grids.h"
#include "nodes/data/opaque_volume.h"

namespace terrazzo::join_volumes {

class Joiner {
 public:
  // With the grids of the first block, still without voxels. Throws Error "unsupported-grid".
  explicit Joiner(const Volume& first);
  // Copies all voxels. The block's grids are like those of the first one.
  void add(const Volume& block);
  // `resolution` of the result is zero.
  Volume take();

 private:
  std::vector<openvdb::GridBase::Ptr> grids_;
};

// The bytes that the grids take in memory.
double bytes_of(const Volume&);

}  // namespace terrazzo::join_volumes

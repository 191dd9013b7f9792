// One block of a solid of phases: a slab across z, from coarse to fine.
#pragma once

#include "nodes/media/annealing/descent.h"

namespace terrazzo::annealing {

// At every level, blocks that meet share kSeam layers on both sides of the cut, the seam. It depends on the
// seam below it in the descent alone, so both blocks make the same. The rest of a block is annealed beside
// its two seams, which no longer change.
class Block {
 public:
  static constexpr int kSeam = 12;

  // Of at least two blocks.
  Block(Descent&, const CoarseSolid&, int blocks, int block, std::uint64_t seed);

  // Makes the next level. Its last one has the pictures' fractions.
  AnnealedLevel refine(int stride, const Work&);

  // The block and all of both seams. The seam above the last block is that below the first.
  const Slab& slab() const { return slab_; }

 private:
  std::uint64_t stream(int part) const;
  Slab seam(const Slab& coarse, int stride, int k, const Work&);
  std::vector<std::int64_t> missing_counts() const;

  Descent& descent_;
  int blocks_, block_;
  std::uint64_t seed_;
  int stride_;                 // of the slabs, which are the whole coarse solid at first
  Slab below_, above_, slab_;  // the seams, and the block with both
};

// Some layers of a slab.
Slab part_of(const Slab&, const Layers&);

}  // namespace terrazzo::annealing

// The geometry of a packing on a lattice, slab by slab. It does not depend on colors, so it is kept while
// they change.
#pragma once

#include <memory>

#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/volumes/voxelize/lattice.h"
#include "nodes/volumes/voxelize/slab.h"
#include "runtime/intermediates.h"
#include "runtime/work.h"

namespace terrazzo::voxelize {

// Throws Error "bad-particles", "open-mesh".
void check(const Particles&, const Shapes&);

class Slabs {
 public:
  // `work`: for the distance lattices, which all slabs share. They are made when a slab needs them. The
  // arguments must outlive this.
  Slabs(const Particles&, const Shapes&, const Lattice&, const Intermediates&, const Work& work);
  ~Slabs();

  // Planes [z0, z1).
  std::shared_ptr<const Slab> get(int z0, int z1, const Work&);

  // What these planes depend on. Only where intermediate results are kept.
  Hash key(int z0, int z1) const;

 private:
  class Distances;

  Slab made(int z0, int z1, const Work&);

  const Particles& particles_;
  const Shapes& shapes_;
  const Lattice& lattice_;
  const Intermediates& intermediates_;
  Work work_;
  Particles uncolored_;
  std::unique_ptr<Distances> distances_;
  std::vector<CellBox> boxes_;  // of each particle
};

}  // namespace terrazzo::voxelize

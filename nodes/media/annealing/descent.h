// What the levels of a solid share, from coarse to fine, and the annealing of one of them.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "nodes/media/annealing/anneal.h"
#include "nodes/media/annealing/level.h"

namespace terrazzo::annealing {

// Layers across z of one level of a solid. `first` may be negative, since the solid tiles.
struct Slab {
  int first = 0;
  Vec3i size = Vec3i::Zero();
  std::vector<std::uint8_t> phase;  // x fastest
};

class Descent {
 public:
  // Keeps references to both.
  Descent(const std::vector<media::PhaseMap>&, const AnnealOptions&);

  const std::vector<int>& strides() const {
    return strides_;
  }  // voxels of the solid per voxel; coarse to fine
  Vec3i size_at(int stride) const { return annealing::size_at(options_.size, stride); }

  // The start of the coarsest level.
  Slab noise(int stride) const;
  // The start of layers of a level, from a coarser one or a slab of it.
  Slab enlarge(const Slab& coarse, int coarse_stride, int stride, const Layers&) const;

  // Anneals the slab, with random numbers of `seed`; at the finest level they also get as many
  // voxels of each phase as `count` says, if it is not empty.
  AnnealedLevel anneal(Slab&, int stride, Ends, std::uint64_t seed, const std::vector<std::int64_t>& count,
                       const Work&);

  // The pictures' fractions as whole numbers of voxels.
  std::vector<std::int64_t> counts(std::int64_t voxels) const;

 private:
  std::vector<PatternTarget> targets(int stride, const Vec3i& size);
  const std::vector<Frequencies>& frequencies(int picture, int spacing);

  const std::vector<media::PhaseMap>& pictures_;
  const AnnealOptions& options_;
  std::vector<int> strides_;
  std::vector<double> fractions_;
  double pixels_;  // observed, of the smallest picture
  std::map<std::pair<int, int>, std::vector<Frequencies>> known_;
};

// How long a level takes, relative to others of the same solid, as if one more round of annealing helps.
double visits(int stride);

}  // namespace terrazzo::annealing

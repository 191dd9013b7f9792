// Coarse-to-fine steepest descent: long structures form while they are only a few pixels wide.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "nodes/common/texture/level_descent.h"
#include "nodes/data/table.h"

namespace terrazzo {

// Target counts for a field of `size` whose offsets, in its own pixels, represent offsets in the source that
// are `stride` times as long. Empty if the source is too small to measure them.
using PairTargets = std::function<std::vector<PairTarget>(int stride, const Vec3i& size)>;

// Measures sections at offsets multiplied by `stride`. Returns nothing if `stride` is above 1 and some offset
// has fewer than four pixel pairs per pair of levels.
std::optional<Cooccurrence> measure_apart(const std::vector<LevelField>& sections, int levels,
                                          const std::vector<Vec3i>& offsets, int stride, const Work&);

enum class Start {
  Coarse,  // at a fraction of the resolution, which is refined
  Noise    // only at full resolution, as in Malzbender and Spach 1993
};

struct DescentOptions {
  int levels = 8;
  int reach = 2;    // the longest offset, pixels
  int sweeps = 10;  // maximum per resolution; stops when a sweep changes nothing
  bool periodic = true;
  Start start = Start::Coarse;
  std::uint64_t seed = 1;
};

struct DescentSweep {
  int stride = 1;           // source pixels per pixel
  int sweep = 0;            // 0: initial state
  double error = 0;         // E after the sweep
  std::size_t changed = 0;  // pixels
};

struct DescentResult {
  LevelField field;
  double noise_error = 0;  // E of noise at full resolution
  std::vector<DescentSweep> sweeps;
};

// Starts from noise with the histogram of `source` at the coarsest resolution 2^k at which the field is still
// four times as long as the offsets reach and `targets` are available. Each finer resolution starts from the
// enlarged coarser field. A coarse pixel represents one of its source pixels, not their mean, so its targets
// are the source's own counts at longer offsets.
DescentResult descend(const std::vector<const LevelField*>& source, const Vec3i& size, const PairTargets&,
                      const DescentOptions&, const Work& = {});

Table descent_table(const std::vector<DescentSweep>&);

}  // namespace terrazzo

// Fields from coarse to fine by steepest descent: long structures find their places while they are a few
// pixels wide.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "nodes/common/level_descent.h"
#include "nodes/data/table.h"

namespace terrazzo {

// The counts wanted of a field of `size` whose offsets, in its own pixels, stand for `stride` times as long
// ones in the source; none where the source is too small to tell.
using PairTargets = std::function<std::vector<PairTarget>(int stride, const Vec3i& size)>;

// Of sections at offsets `stride` times as long; nothing where, with a stride above 1, some offset has fewer
// than four pairs of pixels for every pair of levels.
std::optional<Cooccurrence> measure_apart(const std::vector<LevelField>& sections, int levels,
                                          const std::vector<Vec3i>& offsets, int stride, const Work&);

struct DescentSettings {
  int levels = 8;
  int reach = 2;    // the longest offset, pixels
  int sweeps = 10;  // of each resolution, at most: it ends when a sweep changes nothing
  bool periodic = true;
  bool from_noise = false;  // at full resolution alone, as in Malzbender and Spach 1993
  std::uint64_t seed = 1;
};

struct DescentSweep {
  int stride = 1;           // source pixels a pixel
  int sweep = 0;            // 0: the start
  double error = 0;         // E, afterwards
  std::size_t changed = 0;  // pixels
};

struct DescentResult {
  LevelField field;
  double noise_error = 0;  // E of noise at full resolution
  std::vector<DescentSweep> sweeps;
};

// From noise of the histogram of `source` at the coarsest resolution, 2^k times coarser, at which the field
// is four times as long as the offsets reach and `targets` are known; each finer one starts as the coarser
// one enlarged. A coarse pixel stands for one of its source pixels, not for their mean, so that its targets
// are the source's own counts at longer offsets.
DescentResult descend(const std::vector<const LevelField*>& source, const Vec3i& size, const PairTargets&,
                      const DescentSettings&, const Work& = {});

Table descent_table(const std::vector<DescentSweep>&);

}  // namespace terrazzo

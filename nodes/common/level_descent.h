// Steepest descent in the error of co-occurrence matrices, one pixel after another (Malzbender and Spach
// 1993, section 3; ERRATA 9).
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/cooccurrence.h"
#include "runtime/work.h"

namespace terrazzo {

// Pairs at an offset and how many of each kind are wanted, [home][remote].
struct PairTarget {
  Vec3i offset;
  std::vector<std::int32_t> counts;
};

// A field on the way to its targets. The difference D = counts − targets is kept for every offset, as int32
// and twice, as rows of the home level and as rows of the remote level, so that all levels of a pixel are
// tried at once: with the pixel taken out, level t costs Σ 2·(D[t, r⁺] + D[r⁻, t]) + 2, and 2 more where both
// are one entry (r⁺ = r⁻ = t).
class LevelDescent {
 public:
  // Every pixel of `start` has a level. The offsets are shorter than the field on every axis. What leaves a
  // periodic field comes in on the other side; otherwise it counts for nothing, and the squares of an offset
  // are weighted by (pixels / pairs)², the paper's normalisation.
  LevelDescent(const LevelField& start, int levels, bool periodic, const std::vector<PairTarget>&);

  // Visits every pixel once, in an order that the seed shuffles, and gives it the level with the smallest
  // error; of equal ones it keeps the one it has. Returns the number of pixels changed.
  std::size_t sweep(std::uint64_t seed, const Work& = {});

  // Σ over targets and pairs of levels of ((counts − target) / pairs)².
  double error() const;
  LevelField field() const;
  // Counts as they were kept up to date: [target][home][remote].
  std::vector<std::int32_t> counts() const;

 private:
  template <int Vectors, bool Weighted>
  std::size_t visit(const std::uint32_t* pixels, std::size_t n);
  void place(std::uint32_t padded, std::uint8_t level);

  int levels_, width_;  // width_: levels, filled up to whole vectors
  bool periodic_, weighted_ = false;
  Vec3i size_, pad_, padded_;
  std::vector<std::uint8_t> levels_of_;  // with a border: copies of the other side, or level `levels_`
  std::vector<std::ptrdiff_t> step_;     // of each offset in levels_of_
  std::vector<std::int32_t> by_home_, by_remote_;  // D, [target][row, the last for "outside"][width_]
  std::vector<double> weight_, pairs_;
  std::vector<std::int32_t> target_;
  std::vector<std::uint32_t> order_;
};

// Noise with the histogram of `source` (its pixels with a level): shares rounded to whole pixels.
LevelField level_noise(const std::vector<const LevelField*>& source, int levels, const Vec3i& size,
                       std::uint64_t seed);

}  // namespace terrazzo

// Steepest descent on the error of co-occurrence matrices, pixel by pixel (Malzbender and Spach 1993, section
// 3; errata 9, docs/errata.md).
#pragma once

#include <cstdint>
#include <vector>

#include "nodes/common/texture/cooccurrence.h"
#include "runtime/work.h"

namespace terrazzo {

// An offset and its target counts, [home][remote].
struct PairTarget {
  Vec3i offset;
  std::vector<std::int32_t> counts;
};

// A field that is optimized towards target counts. The difference D = counts − targets is stored as int32 for
// every offset, once with rows by home level and once by remote level, so that all levels of a pixel are
// tested in one pass: with the pixel removed, level t costs Σ 2·(D[t, r⁺] + D[r⁻, t]) + 2, and 2 more if both
// are the same entry (r⁺ = r⁻ = t).
class LevelDescent {
 public:
  // Every pixel of `start` must have a level, and the offsets must be shorter than the field on every axis. A
  // periodic field wraps around. Otherwise pairs across the edges are not counted, and each offset's squares
  // are weighted by (pixels / pairs)², as the paper normalizes them.
  LevelDescent(const LevelField& start, int levels, bool periodic, const std::vector<PairTarget>&);

  // Visits every pixel once in random order and assigns the level with the smallest error; ties keep the
  // current level. Returns the number of changed pixels.
  std::size_t sweep(std::uint64_t seed, const Work& = {});

  // Σ over targets and pairs of levels of ((counts − target) / pairs)².
  double error() const;
  LevelField field() const;
  // The incrementally updated counts: [target][home][remote].
  std::vector<std::int32_t> counts() const;

 private:
  template <int Vectors, bool Weighted>
  std::size_t visit(const std::uint32_t* pixels, std::size_t n);
  void place(std::uint32_t padded, std::uint8_t level);

  int levels_, width_;  // width_: levels rounded up to whole vectors
  bool periodic_, weighted_ = false;
  Vec3i size_, pad_, padded_;
  std::vector<std::uint8_t> levels_of_;  // with a border: copies of the opposite side, or level `levels_`
  std::vector<std::ptrdiff_t> step_;     // of each offset in levels_of_
  std::vector<std::int32_t> by_home_, by_remote_;  // D, [target][row; the last row is "outside"][width_]
  std::vector<double> weight_, pairs_;
  std::vector<std::int32_t> target_;
  std::vector<std::uint32_t> order_;
};

// Random noise with the histogram of the pixels of `source` that have a level, rounded to whole pixels.
LevelField level_noise(const std::vector<const LevelField*>& source, int levels, const Vec3i& size,
                       std::uint64_t seed);

}  // namespace terrazzo

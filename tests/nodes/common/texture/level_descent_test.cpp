#include "nodes/common/texture/level_descent.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime/random.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

// Blotches: most pixels copy one of their neighbors.
LevelField blotches(const Vec3i& size, int levels, std::uint64_t seed) {
  LevelField f(size);
  for (int z = 0; z < size.z(); ++z)
    for (int y = 0; y < size.y(); ++y)
      for (int x = 0; x < size.x(); ++x) {
        Random r(seed, 1, f.index(x, y, z));
        const auto fresh = static_cast<std::uint8_t>(r.below(static_cast<std::uint64_t>(levels)));
        const double u = r.uniform();
        f.at[f.index(x, y, z)] = u < 0.5 && x > 0   ? f.at[f.index(x - 1, y, z)]
                                 : u < 0.8 && y > 0 ? f.at[f.index(x, y - 1, z)]
                                 : u < 0.9 && z > 0 ? f.at[f.index(x, y, z - 1)]
                                                    : fresh;
      }
  return f;
}

std::vector<PairTarget> targets_of(const LevelField& source, const Vec3i& size, int levels,
                                   const std::vector<Vec3i>& offsets, bool periodic) {
  const Cooccurrence c = measure_cooccurrence(source, levels, offsets, false);
  std::vector<PairTarget> out;
  for (std::size_t d = 0; d < offsets.size(); ++d) {
    const Vec3i o = offsets[d].cwiseAbs(), left = periodic ? size : Vec3i(size - o);
    out.push_back(
        {offsets[d], scaled_counts(c, d, static_cast<std::int64_t>(left.x()) * left.y() * left.z())});
  }
  return out;
}

TEST(Cooccurrence, CountsPairsAsWritten) {
  LevelField f(Vec3i(3, 2, 1));
  f.at = {0, 1, 1, 0, 0, 1};
  const auto offsets = cooccurrence_offsets(1);
  ASSERT_EQ(offsets.size(), 4u);
  const Cooccurrence c = measure_cooccurrence(f, 2, {Vec3i(1, 0, 0), Vec3i(-1, 1, 0)}, false);
  EXPECT_EQ(c.counts, (std::vector<std::int32_t>{1, 2, 0, 1, 0, 0, 2, 0}));
  EXPECT_EQ(c.pairs, (std::vector<std::int64_t>{4, 2}));
  const Cooccurrence p = measure_cooccurrence(f, 2, {Vec3i(1, 0, 0)}, true);
  EXPECT_EQ(p.counts, (std::vector<std::int32_t>{1, 2, 2, 1}));
  f.at[1] = kNoLevel;
  EXPECT_EQ(measure_cooccurrence(f, 2, {Vec3i(1, 0, 0)}, false).pairs[0], 2);
}

TEST(Cooccurrence, HalfOfTheOffsetsAtEveryScale) {
  EXPECT_EQ(cooccurrence_offsets(2).size(), 12u);
  EXPECT_EQ(cooccurrence_offsets(6).size(), 84u);
  const auto offsets = cooccurrence_offsets(2, 4);
  int longest = 0;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    longest = std::max(longest, offsets[i].cwiseAbs().maxCoeff());
    for (std::size_t j = 0; j < offsets.size(); ++j) {
      EXPECT_NE(offsets[i], Vec3i(-offsets[j]));
      if (i != j) {
        EXPECT_NE(offsets[i], offsets[j]);
      }
    }
  }
  EXPECT_EQ(longest, 16);
}

TEST(Cooccurrence, ScaledCountsKeepTheSum) {
  const auto c = measure_cooccurrence(blotches({37, 23, 1}, 5, 3), 5, cooccurrence_offsets(2), false);
  for (const std::int64_t pairs : {1, 7, 1000, 123457})
    for (std::size_t d = 0; d < c.offsets.size(); ++d) {
      std::int64_t sum = 0;
      const auto scaled = scaled_counts(c, d, pairs);
      for (std::size_t i = 0; i < scaled.size(); ++i) {
        sum += scaled[i];
        EXPECT_LE(std::abs(scaled[i] - static_cast<double>(c.counts[d * 25 + i]) * pairs / c.pairs[d]), 1);
      }
      EXPECT_EQ(sum, pairs);
    }
  LevelField empty(Vec3i(4, 4, 1), kNoLevel);
  const auto none = measure_cooccurrence(empty, 2, {Vec3i(1, 0, 0)}, false);
  EXPECT_EQ(test::code_of([&] { scaled_counts(none, 0, 10); }), "no-pairs");
}

// The incremental counts equal fresh measurements, every change reduces the error by exactly what the descent
// computes, and nothing depends on edges, levels or dimensions.
TEST(LevelDescent, CountsKeptUpToDateEqualFreshOnes) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    Random r(seed, 9);
    const int levels = 2 + static_cast<int>(r.below(seed % 3 == 0 ? 30 : 8));
    const bool periodic = seed % 2 == 0, solid = seed % 4 == 3;
    const auto flat =
        cooccurrence_offsets(1 + static_cast<int>(r.below(3)), 1 + static_cast<int>(r.below(2)));
    std::vector<Vec3i> offsets;
    for (const auto& o : flat)
      for (int axis = 0; axis < (solid ? 3 : 1); ++axis)
        offsets.push_back(solid ? offset_across(axis, o) : o);
    const Vec3i size = solid
                           ? Vec3i(9, 8, 10)
                           : Vec3i(13 + static_cast<int>(r.below(20)), 11 + static_cast<int>(r.below(20)), 1);
    const LevelField source = blotches(solid ? Vec3i(14, 14, 14) : Vec3i(40, 40, 1), levels, seed);
    const LevelField start = level_noise({&source}, levels, size, seed);
    LevelDescent descent(start, levels, periodic, targets_of(source, size, levels, offsets, periodic));
    double error = descent.error();
    for (int k = 0; k < 4; ++k) {
      const std::size_t changed = descent.sweep(seed + static_cast<std::uint64_t>(k));
      if (changed > 0) {
        EXPECT_LT(descent.error(), error) << "seed " << seed;
      } else {
        EXPECT_EQ(descent.error(), error);
      }
      error = descent.error();
      const Cooccurrence fresh = measure_cooccurrence(descent.field(), levels, offsets, periodic);
      ASSERT_EQ(descent.counts(), fresh.counts) << "seed " << seed << " levels " << levels;
    }
  }
}

// Once a sweep changes nothing, no change of a single pixel reduces the error: ΔE is exact, also for entries
// that two of the four changes hit (errata 9, docs/errata.md).
TEST(LevelDescent, EndsWhereNoSingleChangeHelps) {
  for (const bool periodic : {true, false}) {
    const int levels = 4;
    const auto offsets = cooccurrence_offsets(2);
    const LevelField source = blotches({30, 30, 1}, levels, 7);
    const Vec3i size(12, 10, 1);
    const auto targets = targets_of(source, size, levels, offsets, periodic);
    LevelDescent descent(level_noise({&source}, levels, size, 1), levels, periodic, targets);
    int sweeps = 0;
    while (descent.sweep(static_cast<std::uint64_t>(sweeps)) > 0) ASSERT_LT(++sweeps, 200);
    const auto error_of = [&](const LevelField& f) {
      const Cooccurrence c = measure_cooccurrence(f, levels, offsets, periodic);
      double sum = 0;
      for (std::size_t d = 0; d < offsets.size(); ++d)
        for (int i = 0; i < levels * levels; ++i) {
          const double e =
              (c.counts[d * levels * levels + i] - targets[d].counts[i]) / static_cast<double>(c.pairs[d]);
          sum += e * e;
        }
      return sum;
    };
    LevelField f = descent.field();
    const double reached = error_of(f);
    EXPECT_NEAR(reached, descent.error(), 1e-12);
    for (auto& pixel : f.at) {
      const auto own = pixel;
      for (int t = 0; t < levels; ++t) {
        pixel = static_cast<std::uint8_t>(t);
        EXPECT_GE(error_of(f), reached - 1e-9);
      }
      pixel = own;
    }
  }
}

TEST(LevelDescent, ErrorFallsAThousandTimesInFewSweeps) {
  const LevelField source = blotches({128, 128, 1}, 8, 5);
  const auto offsets = cooccurrence_offsets(2);
  const Vec3i size(128, 128, 1);
  LevelDescent descent(level_noise({&source}, 8, size, 1), 8, true,
                       targets_of(source, size, 8, offsets, true));
  const double start = descent.error();
  for (int k = 0; k < 4; ++k) descent.sweep(static_cast<std::uint64_t>(k));
  EXPECT_LT(descent.error(), start / 1000);
}

TEST(LevelDescent, NoiseHasTheHistogram) {
  const LevelField source = blotches({50, 40, 1}, 6, 2);
  const LevelField noise = level_noise({&source}, 6, {33, 47, 1}, 1);
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(static_cast<double>(std::count(noise.at.begin(), noise.at.end(), k)) / noise.at.size(),
                static_cast<double>(std::count(source.at.begin(), source.at.end(), k)) / source.at.size(),
                1e-3);
}

}  // namespace
}  // namespace terrazzo

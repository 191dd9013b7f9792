// Neighbors and merged cells against the box they come from.
#include "nodes/properties/homogenize/cells.h"

#include <gtest/gtest.h>

#include "tests/nodes/properties/homogenize/models.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace homogenize;

std::vector<std::uint8_t> random_voxels(const Vec3i& size, double share, std::uint64_t seed) {
  std::vector<std::uint8_t> out(voxels_in(size));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = Random(seed, 1, i).uniform() < share;
  return out;
}

// Index of the cell of each voxel, or 0.
std::vector<std::size_t> numbers_of(const Cells& cells) {
  std::vector<std::size_t> out(voxels_in(cells.size()), 0);
  for (int z = 0; z < cells.size().z(); ++z)
    for (const Segment& s : cells.plane(z))
      for (int i = 0; i < s.length; ++i) out[cells.voxel(s, z) + i] = s.at + i;
  return out;
}

// The cell of a voxel beyond the box too, if the axis wraps; 0 if there is none.
std::size_t cell_at(const std::vector<std::size_t>& numbers, Vec3i at, const Vec3i& n,
                    const std::array<bool, 3>& wraps) {
  for (int a = 0; a < 3; ++a) {
    if (wraps[a]) at[a] = (at[a] + n[a]) % n[a];
    if (at[a] < 0 || at[a] >= n[a]) return 0;
  }
  return numbers[voxel_at(at.x(), at.y(), at.z(), n)];
}

// Calls visit(segment, i, voxel) for each cell.
template <class Visit>
void each_cell(const Cells& cells, Visit&& visit) {
  for (int z = 0; z < cells.size().z(); ++z)
    for (const Segment& s : cells.plane(z))
      for (int i = 0; i < s.length; ++i) visit(s, i, Vec3i(s.x + i, s.y, z));
}

TEST(Cells, OfEveryLevelAreInOrderWithTheirNeighborsOfOtherColors) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Vec3i size = seed % 3 == 0 ? Vec3i(9, 1, 6) : seed % 3 == 1 ? Vec3i(7, 18, 5) : Vec3i(2, 11, 14);
    const std::array<bool, 3> wraps{seed % 2 == 0, seed % 4 < 2, seed % 5 < 3};
    const auto open = random_voxels(size, 0.2 + 0.07 * static_cast<double>(seed), seed);
    const std::vector<Cells> levels = levels_of(size, wraps, open, test::kAmple, {});
    const auto first = numbers_of(levels[0]);
    for (std::size_t i = 0; i < open.size(); ++i) EXPECT_EQ(first[i] != 0, open[i] != 0) << seed;
    for (const Cells& cells : levels) {
      const Vec3i& n = cells.size();
      const auto numbers = numbers_of(cells);
      std::size_t expected = cells.first();
      for (const std::size_t number : numbers) {
        if (number != 0) EXPECT_EQ(number, expected++);
      }
      EXPECT_EQ(cells.length(), expected);
      std::vector<int> color(cells.length(), -1);
      each_cell(cells, [&](const Segment& s, int i, const Vec3i& at) {
        color[s.at + i] = 2 * s.seams + at.sum() % 2;
        EXPECT_LE(s.seams, cells.seams());
      });
      each_cell(cells, [&](const Segment& s, int i, const Vec3i& at) {
        for (int a = 0; a < 3; ++a)
          for (const int by : {-1, 1}) {
            const std::size_t found = by == 1 ? s.next(a, i) : s.previous(a, i);
            const std::size_t truth = cell_at(numbers, at + by * Vec3i::Unit(a), n, wraps);
            EXPECT_EQ(found < cells.first() ? 0 : found, truth) << seed << " axis " << a;
            if (truth != 0 && n[a] > 1) {
              EXPECT_NE(color[truth], color[s.at + i]) << seed << " axis " << a;
            }
          }
      });
    }
  }
}

TEST(Cells, AreRefusedIfTheyAreTooManyOrTooLong) {
  const Vec3i n(16, 16, 16), line(70'000, 1, 1);
  const std::array<bool, 3> wraps{true, true, true};
  const auto noise = random_voxels(n, 0.5, 3);
  EXPECT_EQ(test::code_of([&] { levels_of(n, wraps, noise, 40'000, {}); }), "too-large");
  EXPECT_EQ(test::code_of([&] {
              levels_of(line, wraps, std::vector<std::uint8_t>(voxels_in(line), 1), test::kAmple, {});
            }),
            "too-large");
}

TEST(Cells, MergeWhereAnyOfEightIsOpen) {
  const Vec3i n(13, 10, 7);
  const std::vector<Cells> levels =
      levels_of(n, {true, false, true}, random_voxels(n, 0.15, 5), test::kAmple, {});
  ASSERT_GT(levels.size(), 1U);
  EXPECT_LE(levels.back().size().maxCoeff(), 4);
  for (std::size_t k = 0; k + 1 < levels.size(); ++k) {
    const auto coarse = numbers_of(levels[k + 1]);
    std::vector<bool> has_child(levels[k + 1].length(), false);
    each_cell(levels[k], [&](const Segment& s, int i, const Vec3i& at) {
      const std::size_t parent = s.parent + (s.x % 2 + i) / 2;
      EXPECT_EQ(parent, coarse[voxel_at(at.x() / 2, at.y() / 2, at.z() / 2, levels[k + 1].size())]);
      has_child[parent] = true;
    });
    for (std::size_t c = levels[k + 1].first(); c < has_child.size(); ++c) EXPECT_TRUE(has_child[c]);
  }
}

TEST(Cells, OfNoOpenVoxelAreNone) {
  const Vec3i n(6, 5, 4);
  for (const Cells& cells :
       levels_of(n, {true, true, true}, std::vector<std::uint8_t>(voxels_in(n), 0), test::kAmple, {}))
    EXPECT_EQ(cells.length(), cells.first());
}

}  // namespace
}  // namespace terrazzo

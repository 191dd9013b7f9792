// What is connected across the box.
#include "nodes/packing/measure3d/percolation.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/nodes/packing/measure3d/blocks.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace measure3d;

using Shares = std::array<double, 3>;

Percolation percolation(const Vec3i& n, bool periodic, const test::LabelAt& label) {
  return percolation_of(test::classes_of(n, Vec3::Ones(), periodic, label), test::kPlenty, {})[1];
}

TEST(Measure3DPercolation, OfASlabIsWithinIt) {
  const auto slab = [](int, int, int z) { return z > 2 && z < 6 ? 1 : 0; };
  for (const bool periodic : {true, false}) {
    const auto p = percolation({9, 10, 11}, periodic, slab);
    EXPECT_EQ(p.across, (Shares{1, 1, 0}));
    EXPECT_EQ(p.largest, 1);
    EXPECT_EQ(p.pieces, 1u);
  }
}

// A path of voxels that share faces, by its steps along the axes; it begins at (1, 1, 1) and wraps.
test::LabelAt path(int n, const std::vector<Vec3i>& steps, int times) {
  std::vector<char> in(static_cast<std::size_t>(n) * n * n, 0);
  Vec3i at(1, 1, 1);
  const auto mark = [&] {
    in[voxel_at(wrap_index(at.x(), n), wrap_index(at.y(), n), wrap_index(at.z(), n), Vec3i::Constant(n))] = 1;
  };
  mark();
  for (int k = 0; k < times; ++k)
    for (const Vec3i& step : steps) {
      at += step;
      mark();
    }
  return [=](int x, int y, int z) { return in[voxel_at(x, y, z, Vec3i::Constant(n))]; };
}

TEST(Measure3DPercolation, IsFoundByWinding) {
  constexpr int n = 16;
  const Vec3i x(1, 0, 0), y(0, 1, 0), z(0, 0, 1), size(n, n, n);
  // Diagonal rods that meet their own copies only through the border.
  EXPECT_EQ(percolation(size, true, path(n, {x, y}, n)).across, (Shares{1, 1, 0}));
  EXPECT_EQ(percolation(size, true, path(n, {x, y, z}, n)).across, (Shares{1, 1, 1}));
  EXPECT_EQ(percolation(size, true, path(n, {x, x, z}, n)).across, (Shares{1, 0, 1}));
  EXPECT_EQ(percolation(size, true, path(n, {y, -z}, n)).across, (Shares{0, 1, 1}));
  EXPECT_EQ(percolation(size, true, path(n, {x}, n)).across, (Shares{1, 0, 0}));
  // One step less, and there is a gap. It still touches both sides.
  EXPECT_EQ(percolation(size, true, path(n, {z}, n - 2)).across, (Shares{0, 0, 0}));
  // Through the border and back again.
  EXPECT_EQ(percolation(size, true, path(n, {x, x, x, y, y, -x, -x, -x, -x, -x, -x}, 1)).across,
            (Shares{0, 0, 0}));
  // From side to side, but its ends do not meet across the border.
  const auto bent = [](int a, int b, int c) {
    return c == 3 && (a < 8 ? b == 2 : a > 8 ? b == 9 : b >= 2 && b <= 9);
  };
  EXPECT_EQ(percolation(size, true, bent).across, (Shares{0, 0, 0}));
  EXPECT_EQ(percolation(size, false, bent).across, (Shares{1, 0, 0}));
}

TEST(Measure3DPercolation, SharesAreOfVoxelsOfThePhase) {
  // A rod of 10 voxels that reaches across, and a cube of 8 that does not.
  const auto two = [](int x, int y, int z) {
    return (y == 2 && z == 2) || (x > 3 && x < 6 && y > 5 && y < 8 && z > 5 && z < 8) ? 1 : 0;
  };
  const auto p = percolation({10, 10, 10}, false, two);
  EXPECT_NEAR(p.across[0], 10.0 / 18, 1e-12);
  EXPECT_NEAR(p.largest, 10.0 / 18, 1e-12);
  EXPECT_EQ(p.pieces, 2u);
  // Corners and edges of voxels do not connect.
  EXPECT_EQ(percolation({8, 8, 8}, true, [](int x, int y, int z) { return (x + y + z) % 2; }).pieces, 256u);
  EXPECT_EQ(test::code_of([] {
              percolation_of(test::classes_of({9, 9, 9}, Vec3::Ones(), true, test::random_labels(2, 1, 1)),
                             1000, {});
            }),
            "too-large");
}

// By walking through the periods: a voxel that is reached in two different ones winds along their difference.
Shares across_by_walking(const Classes& c) {
  const Vec3i n = c.box.size;
  const auto index = [&](const Vec3i& v) {
    return voxel_at(wrap_index(v.x(), n.x()), wrap_index(v.y(), n.y()), wrap_index(v.z(), n.z()), n);
  };
  std::vector<char> done(c.of.size(), 0);
  Shares out{};
  for (std::size_t first = 0; first < c.of.size(); ++first) {
    if (c.of[first] != 1 || done[first]) continue;
    std::map<std::size_t, Vec3i> reached;
    std::array<bool, 3> winds{};
    const auto nx = static_cast<std::size_t>(n.x()), ny = static_cast<std::size_t>(n.y());
    std::vector<Vec3i> stack{Vec3i(static_cast<int>(first % nx), static_cast<int>(first / nx % ny),
                                   static_cast<int>(first / nx / ny))};
    reached[first] = stack[0];
    while (!stack.empty()) {
      const Vec3i at = stack.back();
      stack.pop_back();
      for (int k = 0; k < 6; ++k) {
        const Vec3i to = at + (k % 2 ? 1 : -1) * Vec3i::Unit(k / 2);
        if (c.of[index(to)] != 1) continue;
        const auto [it, fresh] = reached.emplace(index(to), to);
        if (fresh) stack.push_back(to);
        for (int a = 0; a < 3; ++a)
          if (it->second[a] != to[a]) winds[static_cast<std::size_t>(a)] = true;
      }
    }
    for (const auto& [i, v] : reached) done[i] = 1;
    for (std::size_t a = 0; a < 3; ++a)
      if (winds[a]) out[a] += static_cast<double>(reached.size()) / static_cast<double>(c.voxels[1]);
  }
  return out;
}

TEST(Measure3DPercolation, OfRandomVoxelsIsWhatAWalkFinds) {
  double some = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto c = test::classes_of({6, 5, 7}, Vec3::Ones(), true, [&](int x, int y, int z) {
      return Random(seed, 1, static_cast<std::uint64_t>((z * 5 + y) * 6 + x)).uniform() < 0.3 ? 1 : 0;
    });
    const auto found = percolation_of(c, test::kPlenty, {})[1].across, expected = across_by_walking(c);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(found[a], expected[a], 1e-12) << seed << " " << a;
      some += expected[a];
    }
  }
  EXPECT_GT(some, 5);
  EXPECT_LT(some, 110);
}

}  // namespace
}  // namespace terrazzo

// Permeability against channels, ducts and published arrays of balls.
#include "nodes/properties/homogenize/flow.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/nodes/properties/homogenize/models.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace homogenize;
using namespace test;

// Between plates, n voxels apart: on this grid (n² + 2)/12 times the open share, in the limit n²/12.
TEST(Flow, BetweenPlatesIsExact) {
  for (int across = 0; across < 3; ++across)
    for (const int n : {1, 2, 7}) {
      Vec3i size(4, 5, 3);
      size[across] = n + 2;
      const auto map = test::phase_map(
          size, 2,
          [&](int x, int y, int z) {
            return (across == 0 ? x : across == 1 ? y : z) < n ? 1 : 0;
          },
          Vec3::Constant(0.5));
      const Solved s = permeate(map, {0, 1}, Boundary::Periodic, kAllAxes, kFine, kAmple, {});
      EXPECT_FALSE(s.connected[across]);
      EXPECT_EQ(s.effective(across, across), 0);
      for (const int a : {(across + 1) % 3, (across + 2) % 3})
        EXPECT_NEAR(s.effective(a, a) / (0.25 * (n * n + 2) / 12.0 * n / (n + 2)), 1, 1e-5) << across << n;
    }
}

// A square duct: 0.035144 times its area (White 2006).
TEST(Flow, ThroughADuctConvergesToTheSeries) {
  double before = 1;
  for (const int n : {8, 16}) {
    const auto map =
        test::phase_map({4, n + 1, n + 1}, 2, [&](int, int y, int z) { return y < n && z < n ? 1 : 0; });
    const double k = permeate(map, {0, 1}, Boundary::Periodic, kAlongX, kFine, kAmple, {}).effective(0, 0);
    const double error = std::abs(k * (n + 1) * (n + 1) / (0.035144 * std::pow(n, 4)) - 1);
    EXPECT_LT(error, 0.3 * before);
    before = error;
  }
  EXPECT_LT(before, 0.02);
}

// The same duct with a given pressure on both ends, and walls around the volume.
TEST(Flow, BetweenFixedPressuresIsThatOfTheDuct) {
  const int n = 6;
  const auto open = test::phase_map({5, n, n}, 1, [](int, int, int) { return 0; });
  const auto walled =
      test::phase_map({5, n + 1, n + 1}, 2, [&](int, int y, int z) { return y < n && z < n ? 1 : 0; });
  const double fixed = permeate(open, {1}, Boundary::Fixed, kAlongX, kFine, kAmple, {}).effective(0, 0);
  const double periodic =
      permeate(walled, {0, 1}, Boundary::Periodic, kAlongX, kFine, kAmple, {}).effective(0, 0);
  EXPECT_NEAR(fixed / (periodic * (n + 1) * (n + 1) / (n * n)), 1, 1e-5);
}

// A given pressure at both ends is a mirror: the same as a periodic box that contains the mirror image too,
// with walls between the copies along the other axes.
TEST(Flow, BetweenFixedPressuresIsThatOfTheMirrorImage) {
  for (const auto& [axis, n] : {std::pair(0, Vec3i(6, 5, 7)), std::pair(1, Vec3i(6, 5, 7)),
                                std::pair(2, Vec3i(6, 5, 7)), std::pair(1, Vec3i(8, 1, 5))}) {
    const auto map = test::random_map(n, 4, 3 + static_cast<std::uint64_t>(axis));  // phase 3 is solid
    Vec3i doubled = n + Vec3i::Ones();
    doubled[axis] = 2 * n[axis];
    const auto mirrored = test::phase_map(
        doubled, 4,
        [&](int x, int y, int z) {
          Vec3i at(x, y, z);
          if (at[axis] >= n[axis]) at[axis] = doubled[axis] - 1 - at[axis];
          if ((at.array() >= n.array()).any()) return 3;
          return static_cast<int>(map.phase[voxel_at(at.x(), at.y(), at.z(), n)]);
        },
        Vec3(1, 1.2, 0.9));
    auto stretched = map;
    stretched.box.spacing = mirrored.box.spacing;
    std::array<bool, 3> along{};
    along[axis] = true;
    const std::vector<char> open{1, 1, 1, 0};
    const Solved fixed = permeate(stretched, open, Boundary::Fixed, along, kFine, kAmple, {});
    const Solved periodic = permeate(mirrored, open, Boundary::Periodic, along, kFine, kAmple, {});
    const double share = static_cast<double>(voxels_in(n)) * 2 / static_cast<double>(voxels_in(doubled));
    EXPECT_NEAR(fixed.effective(axis, axis) * share / periodic.effective(axis, axis), 1, 1e-6) << axis;
    ASSERT_EQ(fixed.flow.size(), voxels_in(n));
    std::vector<std::size_t> copy;  // of each voxel, in the doubled box
    for (int z = 0; z < n.z(); ++z)
      for (int y = 0; y < n.y(); ++y)
        for (int x = 0; x < n.x(); ++x) copy.push_back(voxel_at(x, y, z, doubled));
    const std::size_t fast = std::max_element(fixed.flow.begin(), fixed.flow.end()) - fixed.flow.begin();
    const double fastest = fixed.flow[fast];
    EXPECT_GT(fastest, 0);
    // The pressure of a periodic box has any mean.
    const double mean = periodic.potential[copy[fast]] - fixed.potential[fast];
    for (std::size_t i = 0; i < copy.size(); ++i) {
      EXPECT_NEAR(fixed.flow[i], periodic.flow[copy[i]], 1e-5 * fastest) << axis << i;
      if (fixed.flow[i] > 0) {
        EXPECT_NEAR(fixed.potential[i], periodic.potential[copy[i]] - mean, 1e-4) << axis << i;
      }
    }
  }
}

// Drag of a simple cubic array of balls, relative to Stokes' for one (Zick and Homsy 1982, table 2).
TEST(Flow, AroundACubicArrayOfBallsHasThePublishedDrag) {
  for (const auto& [fraction, drag] : {std::pair(0.125, 4.292), std::pair(0.343, 15.4)}) {
    const int n = 40;
    const auto map = test::ball(n, fraction);
    const double f = map.fraction[1], radius = n * std::cbrt(3 * f / (4 * M_PI));
    const double k = permeate(map, {1, 0}, Boundary::Periodic, kAlongX, kUsual, kAmple, {}).effective(0, 0);
    EXPECT_NEAR(2 * radius * radius / (9 * f * k) / drag, 1, 0.02) << fraction;
  }
}

TEST(Flow, ThroughRandomPoresIsSymmetricAndScalesWithTheSquareOfTheVoxel) {
  // Balls that overlap, as a sum of few of them.
  const auto solid = [](int x, int y, int z) {
    bool in = false;
    for (std::uint64_t k = 0; k < 20; ++k) {
      Random r(9, 1, k);
      Vec3 d = Vec3(x, y, z) - 24 * Vec3(r.uniform(), r.uniform(), r.uniform());
      for (int a = 0; a < 3; ++a) d[a] -= 24 * std::round(d[a] / 24);
      in |= d.norm() < 5;
    }
    return in ? 1 : 0;
  };
  const auto map = test::phase_map({24, 24, 24}, 2, solid),
             coarse = test::phase_map({24, 24, 24}, 2, solid, {3, 3, 3});
  const Mat3 k = permeate(map, {1, 0}, Boundary::Periodic, kAllAxes, kUsual, kAmple, {}).effective;
  EXPECT_LT((k - k.transpose()).norm(), 1e-4 * k.norm());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Mat3>(k).eigenvalues()[0], 0);
  const Mat3 scaled = permeate(coarse, {1, 0}, Boundary::Periodic, kAllAxes, kUsual, kAmple, {}).effective;
  EXPECT_LT((scaled - 9 * k).norm(), 1e-5 * scaled.norm());
}

// A Boolean model: balls at random places that overlap. Its surface per volume is s = 3/R ε ln(1/ε). Kozeny
// and Carman's ε³/(5 s²) holds at a porosity ε of one half; Weissberg and Prager's 2 R² ε / (9 ln(1/ε)) is an
// upper bound.
TEST(Flow, ThroughOverlappingBallsIsThatOfKozenyAndCarman) {
  const int n = 48, count = 146;
  const double radius = 5;
  std::vector<Vec3> centers;
  for (int k = 0; k < count; ++k) {
    Random r(3, 1, k);
    centers.push_back(n * Vec3(r.uniform(), r.uniform(), r.uniform()));
  }
  const auto map = test::phase_map({n, n, n}, 2, [&](int x, int y, int z) {
    return std::any_of(centers.begin(), centers.end(), [&](const Vec3& c) {
      Vec3 d = Vec3(x, y, z) - c;
      for (int a = 0; a < 3; ++a) d[a] -= n * std::round(d[a] / n);
      return d.squaredNorm() < radius * radius;
    });
  });
  const double open = map.fraction[0], surface = 3 / radius * open * std::log(1 / open);
  const double k =
      permeate(map, {1, 0}, Boundary::Periodic, kAllAxes, kUsual, kAmple, {}).effective.trace() / 3;
  EXPECT_NEAR(open, 0.5, 0.05);
  EXPECT_NEAR(k / (std::pow(open, 3) / (5 * surface * surface)), 1, 0.25);
  EXPECT_LT(k, 2 * radius * radius * open / (9 * std::log(1 / open)));
}

// A slit whose voxels are not cubes: the profile depends on the edge across only.
TEST(Flow, KnowsTheEdgesOfVoxels) {
  const int n = 5;
  const auto map =
      test::phase_map({3, n + 1, 4}, 2, [&](int, int y, int) { return y < n ? 1 : 0; }, {0.7, 0.2, 1.5});
  const Mat3 k = permeate(map, {0, 1}, Boundary::Periodic, kAllAxes, kFine, kAmple, {}).effective;
  for (const int a : {0, 2}) EXPECT_NEAR(k(a, a) / (0.04 * (n * n + 2) / 12.0 * n / (n + 1)), 1, 1e-5);
}

TEST(Flow, HasEqualBitsOnAnyNumberOfThreads) {
  const auto map = test::ball(43, 0.3);
  for (const Boundary boundary : {Boundary::Periodic, Boundary::Fixed}) {
    const auto all = test::with_threads([&] {
      return permeate(map, {1, 0}, boundary, kAlongX, kUsual, kAmple, {});
    });
    for (const Solved& s : all) {
      EXPECT_EQ(s.effective, all[0].effective);
      EXPECT_EQ(s.flow, all[0].flow);
    }
  }
}

TEST(Flow, FailsWithTheResidualAndBeforeItTakesTooMuchMemory) {
  const auto map = test::ball(16, 0.3);
  EXPECT_EQ(test::code_of([&] {
              permeate(map, {1, 0}, Boundary::Periodic, kAlongX, {1e-9, 2}, kAmple, {});
            }),
            "not-converged");
  EXPECT_EQ(test::code_of([&] {
              permeate(map, {1, 0}, Boundary::Periodic, kAlongX, kUsual, 100'000, {});
            }),
            "too-large");
}

// Of a rock with few pores, only the pores take memory.
TEST(Flow, NeedsMemoryForItsPores) {
  const auto duct =
      test::phase_map({40, 40, 40}, 2, [](int, int y, int z) { return y < 4 && z < 4 ? 0 : 1; });
  const std::uint64_t memory = 2'000'000;
  for (const Boundary boundary : {Boundary::Periodic, Boundary::Fixed}) {
    EXPECT_GT(permeate(duct, {1, 0}, boundary, kAlongX, kUsual, memory, {}).effective(0, 0), 0);
    EXPECT_EQ(test::code_of([&] {
                permeate(duct, {1, 1}, boundary, kAlongX, kUsual, memory, {});
              }),
              "too-large");
  }
}

}  // namespace
}  // namespace terrazzo

// Conductivity against closed forms, published arrays, and a dense solution of the same equations.
#include "nodes/properties/homogenize/conduction.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "nodes/properties/homogenize/bounds.h"
#include "tests/nodes/properties/homogenize/models.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace homogenize;
using namespace test;

Mat3 conductivity_of(const PhaseMap& map, const std::vector<double>& values,
                     Boundary boundary = Boundary::Periodic, const Accuracy& accuracy = kFine) {
  return conduct(map, values, boundary, kAllAxes, accuracy, kAmple, {}).effective;
}

TEST(Conduction, OfLayersIsInSeriesAndParallel) {
  const std::vector<double> values{1, 10, 250};
  for (const Boundary boundary : {Boundary::Periodic, Boundary::Fixed})
    for (int across = 0; across < 3; ++across) {
      Vec3i size(5, 6, 7);
      size[across] = 12;
      const auto map = test::phase_map(size, 3,
                                       [&](int x, int y, int z) {
                                         return (across == 0 ? x : across == 1 ? y : z) / 3 % 3;
                                       },
                                       {0.5, 1, 0.7});
      const Bounds wiener = wiener_bounds(map.fraction, values);
      const Mat3 k = conductivity_of(map, values, boundary);
      for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(k(a, a) / (a == across ? wiener.low : wiener.high), 1, 1e-6) << across << a;
        for (int b = 0; b < a; ++b) EXPECT_NEAR(k(a, b), 0, 1e-6 * wiener.high);
      }
    }
}

// The same equations, assembled as a matrix and solved directly.
double dense_conduction(const PhaseMap& map, const std::vector<double>& values, int axis, bool wraps) {
  const Vec3i& n = map.box.size;
  const Eigen::Index count = static_cast<Eigen::Index>(map.phase.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(count);
  const auto k = [&](Eigen::Index i) { return values[map.phase[static_cast<std::size_t>(i)]]; };
  const auto every_face = [&](auto&& visit) {
    for (int z = 0; z < n.z(); ++z)
      for (int y = 0; y < n.y(); ++y)
        for (int x = 0; x < n.x(); ++x)
          for (int d = 0; d < 3; ++d) {
            Vec3i to(x, y, z);
            to[d] = (to[d] + 1) % n[d];
            const auto i = static_cast<Eigen::Index>(voxel_at(x, y, z, n)),
                       j = static_cast<Eigen::Index>(voxel_at(to.x(), to.y(), to.z(), n));
            const double sum = k(i) + k(j);
            visit(i, j, d, to[d] == 0, sum > 0 ? 2 * k(i) * k(j) / sum : 0);
          }
  };
  const Vec3& edge = map.box.spacing;
  const double length = n[axis] * edge[axis];
  every_face([&](Eigen::Index i, Eigen::Index j, int d, bool around, double conductivity) {
    const double per_edge = 1 / (edge[d] * edge[d]), g = conductivity * per_edge;
    if (around && !wraps) {
      if (d != axis) return;
      a(i, i) += 2 * k(i) * per_edge;
      a(j, j) += 2 * k(j) * per_edge;
      b(i) += 2 * k(i) * per_edge * length;
      return;
    }
    a(i, i) += g;
    a(j, j) += g;
    a(i, j) -= g;
    a(j, i) -= g;
    if (d == axis && wraps) {
      b(i) += g * edge[d];
      b(j) -= g * edge[d];
    }
  });
  const Eigen::VectorXd x = a.completeOrthogonalDecomposition().solve(b);
  double flow = 0;
  every_face([&](Eigen::Index i, Eigen::Index j, int d, bool around, double g) {
    if (d != axis) return;
    if (wraps) flow += g * ((x(j) - x(i)) / edge[axis] + 1) / static_cast<double>(count);
    if (!wraps && around) flow += 2 * k(j) * x(j) / edge[axis] * n[axis] / static_cast<double>(count);
  });
  return flow;
}

TEST(Conduction, EqualsADenseSolutionOfTheSameEquations) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    // Odd sizes, a single layer, and a contrast of a million.
    const Vec3i size = seed % 3 == 0 ? Vec3i(9, 8, 1) : seed % 3 == 1 ? Vec3i(7, 5, 6) : Vec3i(4, 9, 5);
    const auto map = test::random_map(size, 3, seed);
    const std::vector<double> values =
        seed % 2 == 0 ? std::vector<double>{1, 1e-6, 0.3} : std::vector<double>{2, 5, 1};
    for (const bool wraps : {true, false}) {
      const Mat3 k = conductivity_of(map, values, wraps ? Boundary::Periodic : Boundary::Fixed);
      for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(k(a, a) / dense_conduction(map, values, a, wraps), 1, 1e-6) << seed << wraps << a;
      }
      EXPECT_LT((k - k.transpose()).norm(), 1e-6 * k.norm()) << seed;
    }
  }
}

TEST(Conduction, LiesBetweenTheBoundsOfAnyArrangement) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const auto map = test::random_map({8, 8, 8}, 3, seed);
    const std::vector<double> values{1, 1.0 + 3.0 * static_cast<double>(seed), 0.2};
    const Bounds bounds = wiener_bounds(map.fraction, values);
    const Eigen::SelfAdjointEigenSolver<Mat3> axes(conductivity_of(map, values));
    EXPECT_GT(axes.eigenvalues()[0], bounds.low);
    EXPECT_LT(axes.eigenvalues()[2], bounds.high);
  }
}

// A cubic array of balls of conductivity 10 with a volume fraction of 0.2 (Rayleigh 1892, as corrected by
// McPhedran and McKenzie 1978, equation 21).
TEST(Conduction, OfACubicArrayOfBallsConvergesToRayleighsFormula) {
  const double c = 0.2, alpha = 10;
  const double formula = 1 + 3 * c /
                                 ((alpha + 2) / (alpha - 1) - c -
                                  1.306 * (alpha - 1) / (alpha + 4.0 / 3) * std::pow(c, 10.0 / 3));
  double before = 1;
  for (const int n : {16, 64}) {
    const auto s =
        conduct(test::ball(n, c), {1, alpha}, Boundary::Periodic, {true, false, false}, kUsual, kAmple, {});
    const double error = std::abs(s.effective(0, 0) / formula - 1);
    EXPECT_LT(error, 0.5 * before);
    before = error;
  }
  EXPECT_LT(before, 0.006);
}

// In the plane, a checkerboard conducts √(k₁k₂) (Keller 1964), whatever the contrast.
TEST(Conduction, OfACheckerboardIsTheGeometricMean) {
  const auto map = test::phase_map({96, 96, 1}, 2, [](int x, int y, int) { return (x / 48 + y / 48) % 2; });
  EXPECT_NEAR(conductivity_of(map, {1, 4})(0, 0) / 2, 1, 0.01);
  // Exchanging the phases turns the board.
  EXPECT_NEAR(conductivity_of(map, {4, 1})(1, 1) / conductivity_of(map, {1, 4})(0, 0), 1, 1e-6);
}

TEST(Conduction, WithoutAWayAcrossIsExactlyZero) {
  // A wall across x.
  const auto map = test::phase_map({8, 6, 6}, 2, [](int x, int, int) { return x == 3 ? 0 : 1; });
  for (const Boundary boundary : {Boundary::Periodic, Boundary::Fixed}) {
    const Solved s = conduct(map, {0, 5}, boundary, kAllAxes, kFine, kAmple, {});
    EXPECT_EQ(s.effective(0, 0), 0);
    EXPECT_FALSE(s.connected[0]);
    EXPECT_TRUE(s.connected[1] && s.connected[2]);
    EXPECT_NEAR(s.effective(1, 1), 5 * 7.0 / 8, 1e-6);
  }
}

// A rod that winds around the box diagonally conducts along x and y at once.
TEST(Conduction, FollowsARodThroughThePeriod) {
  const int n = 12;
  const auto map = test::phase_map(
      {n, n, 3}, 2, [](int x, int y, int z) { return z == 1 && (x == y || x == (y + 1) % n) ? 1 : 0; });
  const Solved s = conduct(map, {0, 1}, Boundary::Periodic, kAllAxes, kFine, kAmple, {});
  EXPECT_TRUE(s.connected[0] && s.connected[1] && !s.connected[2]);
  // A staircase of 2n steps in series: the slope of 1 along x and along y adds up.
  EXPECT_NEAR(s.effective(0, 0), s.effective(0, 1), 1e-9);
  EXPECT_NEAR(s.effective(0, 0), n * n / (2.0 * n) / (n * n * 3), 1e-7);
  EXPECT_FALSE(conduct(map, {0, 1}, Boundary::Fixed, kAllAxes, kFine, kAmple, {}).connected[2]);
}

TEST(Conduction, HasEqualBitsOnAnyNumberOfThreads) {
  const auto map = test::random_map({65, 67, 35}, 2, 4);
  for (const Boundary boundary : {Boundary::Periodic, Boundary::Fixed}) {
    const auto all = test::with_threads([&] {
      return conduct(map, {1, 80}, boundary, kAllAxes, kUsual, kAmple, {});
    });
    for (const Solved& s : all) {
      EXPECT_EQ(s.effective, all[0].effective);
      EXPECT_EQ(s.flow, all[0].flow);
      EXPECT_EQ(s.iterations, all[0].iterations);
    }
  }
}

TEST(Conduction, FailsWithTheResidualAndBeforeItTakesTooMuchMemory) {
  const auto map = test::random_map({16, 16, 16}, 2, 5);
  try {
    conduct(map, {1, 1e4}, Boundary::Periodic, kAllAxes, {1e-9, 3}, kAmple, {});
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "not-converged");
    EXPECT_NE(e.diagnostic().message.find("after 3 iterations the residual is"), std::string::npos);
  }
  EXPECT_EQ(test::code_of([&] {
              conduct(map, {1, 2}, Boundary::Periodic, kAllAxes, kUsual, 100'000, {});
            }),
            "too-large");
}

TEST(Conduction, StopsWhenItIsCanceled) {
  const std::atomic<bool> canceled{true};
  const Work work(&canceled, nullptr);
  EXPECT_THROW(
      conduct(test::random_map({9, 9, 9}, 2, 1), {1, 5}, Boundary::Periodic, kAllAxes, kFine, kAmple, work),
      Cancelled);
}

// A phase that does not occur has no effect.
TEST(Conduction, DoesNotDependOnPhasesThatDoNotOccur) {
  auto map = test::random_map({6, 5, 7}, 2, 3);
  const Mat3 before = conductivity_of(map, {1, 4});
  map.names.push_back("absent");
  map.fraction.push_back(0);
  EXPECT_LT((conductivity_of(map, {1, 4, 1e9}) - before).norm(), 1e-6);
}

// The mean of the flow is the effective conductivity where flow has one direction.
TEST(Conduction, FieldHasTheMeanFlow) {
  const auto map = test::phase_map({8, 4, 4}, 2, [](int x, int, int) { return x / 4; });
  for (const Boundary boundary : {Boundary::Periodic, Boundary::Fixed}) {
    const Solved s = conduct(map, {1, 3}, boundary, kAllAxes, kFine, kAmple, {});
    for (const float f : s.flow) EXPECT_NEAR(f, 1.5, 1e-5);
  }
}

}  // namespace
}  // namespace terrazzo

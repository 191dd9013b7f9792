// Stiffness against laminates, a dense finite-element solution, and bounds.
#include "nodes/properties/homogenize/elasticity.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "nodes/properties/homogenize/bounds.h"
#include "tests/nodes/properties/homogenize/models.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace homogenize;
using namespace test;

Stiffness stiffness_of(const PhaseMap& map, const std::vector<Elastic>& values) {
  return stiffness(map, values, kUsual, kAmple, {}).effective;
}

double constrained(const Elastic& e) { return e.lambda() + 2 * e.mu(); }

TEST(Elasticity, OfLayersIsExact) {
  const Elastic a{1, 0.3}, b{100, 0.15};
  for (int across = 0; across < 3; ++across) {
    Vec3i size(3, 5, 4);
    size[across] = 10;
    const auto map = test::phase_map(size, 2, [&](int x, int y, int z) {
      return (across == 0 ? x : across == 1 ? y : z) < 4 ? 1 : 0;
    });
    const double f = 0.4, g = 0.6;  // of b and a
    const double normal = 1 / (g / constrained(a) + f / constrained(b));
    const double ratio = g * a.lambda() / constrained(a) + f * b.lambda() / constrained(b);
    const double shear_across = 1 / (g / a.mu() + f / b.mu()), shear_along = g * a.mu() + f * b.mu();
    const auto own = [](const Elastic& e) {
      return constrained(e) - e.lambda() * e.lambda() / constrained(e);
    };
    const Stiffness c = stiffness_of(map, {a, b});
    const int u = (across + 1) % 3, v = (across + 2) % 3;
    EXPECT_NEAR(c(across, across) / normal, 1, 1e-4);
    EXPECT_NEAR(c(across, u) / (normal * ratio), 1, 1e-4);
    EXPECT_NEAR(c(u, u) / (g * own(a) + f * own(b) + normal * ratio * ratio), 1, 1e-4);
    EXPECT_NEAR(c(u, u) - c(u, v), 2 * shear_along, 1e-3);
    EXPECT_NEAR(c(3 + across, 3 + across) / shear_along, 1, 1e-4);  // yz is 3, xz is 4, xy is 5
    EXPECT_NEAR(c(3 + u, 3 + u) / shear_across, 1, 1e-4);
    EXPECT_NEAR(c(3 + v, 3 + v) / shear_across, 1, 1e-4);
  }
}

using Matrix24 = Eigen::Matrix<double, 24, 24>;
using Strain = Eigen::Matrix<double, 6, 24>;

// Strains at a point of an element with coordinates from 0 to 1, whose node k has the coordinates of its
// bits.
Strain strain_at(const Vec3& p) {
  Strain b = Strain::Zero();
  for (int k = 0; k < 8; ++k) {
    Vec3 value, slope;
    for (int a = 0; a < 3; ++a) {
      value[a] = k >> a & 1 ? p[a] : 1 - p[a];
      slope[a] = k >> a & 1 ? 1 : -1;
    }
    const Vec3 d(slope[0] * value[1] * value[2], value[0] * slope[1] * value[2],
                 value[0] * value[1] * slope[2]);
    for (int a = 0; a < 3; ++a) b(a, 3 * k + a) = d[a];
    b(3, 3 * k + 1) = d[2];
    b(3, 3 * k + 2) = d[1];
    b(4, 3 * k) = d[2];
    b(4, 3 * k + 2) = d[0];
    b(5, 3 * k) = d[1];
    b(5, 3 * k + 1) = d[0];
  }
  return b;
}

Stiffness hooke(const Elastic& e) {
  Stiffness c = Stiffness::Zero();
  c.topLeftCorner<3, 3>().setConstant(e.lambda());
  for (int i = 0; i < 3; ++i) {
    c(i, i) += 2 * e.mu();
    c(3 + i, 3 + i) = e.mu();
  }
  return c;
}

// Trilinear elements with eight integration points, assembled as a matrix and solved directly.
Stiffness dense_stiffness(const PhaseMap& map, const std::vector<Elastic>& values) {
  const Vec3i& n = map.box.size;
  const auto count = static_cast<Eigen::Index>(3 * map.phase.size());
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(count, count), b = Eigen::MatrixXd::Zero(count, 6);
  Stiffness mean = Stiffness::Zero();
  for (std::size_t e = 0; e < map.phase.size(); ++e) {
    const Stiffness c = hooke(values[map.phase[e]]);
    Matrix24 element = Matrix24::Zero();
    Eigen::Matrix<double, 24, 6> load = Eigen::Matrix<double, 24, 6>::Zero();
    for (int g = 0; g < 8; ++g) {
      Vec3 p;
      for (int a = 0; a < 3; ++a) p[a] = 0.5 + (g >> a & 1 ? 0.5 : -0.5) / std::sqrt(3.0);
      const Strain s = strain_at(p);
      element += s.transpose() * c * s / 8;
      load += s.transpose() * c / 8;
    }
    mean += c / static_cast<double>(map.phase.size());
    Eigen::Index node[24];
    for (int j = 0; j < 8; ++j) {
      const int x = static_cast<int>(e) % n.x(), y = static_cast<int>(e) / n.x() % n.y(),
                z = static_cast<int>(e) / n.x() / n.y();
      const std::size_t i =
          voxel_at((x + (j & 1)) % n.x(), (y + (j >> 1 & 1)) % n.y(), (z + (j >> 2)) % n.z(), n);
      for (int a = 0; a < 3; ++a) node[3 * j + a] = static_cast<Eigen::Index>(3 * i) + a;
    }
    for (int i = 0; i < 24; ++i) {
      for (int j = 0; j < 24; ++j) k(node[i], node[j]) += element(i, j);
      b.row(node[i]) -= load.row(i);
    }
  }
  const Eigen::MatrixXd u = k.completeOrthogonalDecomposition().solve(b);
  return mean - b.transpose() * u / static_cast<double>(map.phase.size());
}

TEST(Elasticity, EqualsADenseSolutionOfTheSameElements) {
  for (const std::vector<Elastic>& values :
       {std::vector<Elastic>{{1, 0.3}, {7, 0.1}, {0.4, 0.45}}, {{1, 0.2}, {0, 0}, {30, -0.3}}}) {
    const auto map = test::random_map({4, 3, 5}, 3, 7);
    const Stiffness found = stiffness_of(map, values), expected = dense_stiffness(map, values);
    EXPECT_LT((found - expected).norm(), 2e-5 * expected.norm()) << found << "\n" << expected;
    EXPECT_LT((found - found.transpose()).norm(), 2e-5 * expected.norm());
  }
}

TEST(Elasticity, OfBallsLiesBetweenTheBoundsOfIsotropicArrangements) {
  const auto map = test::ball(24, 0.2);
  const std::vector<Elastic> values{{1, 0.3}, {20, 0.2}};
  const Moduli m = isotropic_part(stiffness_of(map, values));
  const ElasticBounds bounds = hashin_shtrikman(map.fraction, values);
  EXPECT_GT(m.bulk, bounds.bulk.low);
  EXPECT_LT(m.bulk, bounds.bulk.high);
  EXPECT_GT(m.shear, bounds.shear.low);
  EXPECT_LT(m.shear, bounds.shear.high);
}

// Few pores: the bulk modulus is on the bound (Eshelby 1957), K (1 − φ (3K + 4G) / (4G)) to first order.
TEST(Elasticity, OfFewPoresIsThatOfEshelby) {
  const auto map = test::ball(32, 0.02);
  const Elastic solid{1, 0.25};
  const double k = solid.lambda() + 2 * solid.mu() / 3, f = map.fraction[1];
  const double expected = k * (1 - f * (3 * k + 4 * solid.mu()) / (4 * solid.mu()));
  const double found = isotropic_part(stiffness_of(map, {solid, {0, 0}})).bulk;
  EXPECT_NEAR((k - found) / (k - expected), 1, 0.1);
}

TEST(Elasticity, OfOneMaterialIsItsOwn) {
  const Elastic e{210, 0.29};
  const Stiffness found = stiffness_of(test::random_map({4, 6, 3}, 2, 1), {e, e});
  EXPECT_LT((found - hooke(e)).norm(), 1e-5 * found.norm());
  const Moduli m = isotropic_part(found);
  EXPECT_NEAR(m.young(), 210, 0.01);
  EXPECT_NEAR(m.poisson(), 0.29, 1e-5);
}

TEST(Elasticity, DoesNotDependOnPhasesThatDoNotOccur) {
  auto map = test::random_map({6, 5, 7}, 2, 3);
  const Stiffness before = stiffness_of(map, {{1, 0.3}, {4, 0.2}});
  map.names.push_back("absent");
  map.fraction.push_back(0);
  EXPECT_LT((stiffness_of(map, {{1, 0.3}, {4, 0.2}, {1e9, 0.3}}) - before).norm(), 1e-5);
}

TEST(Elasticity, HasEqualBitsOnAnyNumberOfThreads) {
  const auto map = test::random_map({41, 42, 39}, 2, 3);
  const auto all = test::with_threads([&] {
    return stiffness(map, {{1, 0.3}, {5, 0.2}}, {1e-4, 2000}, kAmple, {});
  });
  for (const SolvedStiffness& s : all) {
    EXPECT_EQ(s.effective, all[0].effective);
    EXPECT_EQ(s.stress, all[0].stress);
  }
}

TEST(Elasticity, RefusesBoxesThatAreNoCubesAndTooMuchMemory) {
  auto map = test::random_map({4, 4, 4}, 2, 1);
  EXPECT_EQ(test::code_of([&] { stiffness(map, {{1, 0.3}, {2, 0.3}}, kUsual, 1000, {}); }), "too-large");
  EXPECT_EQ(test::code_of([&] {
              stiffness(map, {{1, 0.3}, {90, 0.3}}, {1e-6, 1}, kAmple, {});
            }),
            "not-converged");
  map.box.spacing = Vec3(1, 1, 2);
  EXPECT_EQ(test::code_of([&] { stiffness(map, {{1, 0.3}, {2, 0.3}}, kUsual, kAmple, {}); }), "not-cubic");
}

}  // namespace
}  // namespace terrazzo

#include "nodes/photograph/load_ebsd/crystal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/nodes/photograph/load_ebsd/sample_map.h"

namespace terrazzo {
namespace {
using namespace load_ebsd;
using Q = Eigen::Quaternionf;

constexpr double kDegree = std::numbers::pi / 180;

std::vector<Symmetry> all_groups() {
  std::vector<Symmetry> out;
  for (int k = 0; k < 11; ++k) out.push_back({static_cast<LaueGroup>(k)});
  return out;
}

double angle(const Q& a, const Q& b, LaueGroup g) {
  return 2 * std::acos(std::min(1.0f, half_angle_cosine(a, b, Symmetry{g}.rotations()))) / kDegree;
}

Q turned(double degrees, Eigen::Vector3f axis) {
  return Q(Eigen::AngleAxisf(static_cast<float>(degrees * kDegree), axis.normalized()));
}

TEST(LoadEBSD, RotationGroupsHaveTheirOrders) {
  const std::vector<std::size_t> orders = {1, 2, 4, 4, 8, 3, 6, 6, 12, 12, 24};
  for (std::size_t k = 0; k < orders.size(); ++k) {
    const auto rotations = all_groups()[k].rotations();
    EXPECT_EQ(rotations.size(), orders[k]) << name_of(all_groups()[k].group);
    for (const auto& a : rotations)  // closed
      for (const auto& b : rotations) EXPECT_GT(half_angle_cosine(Q::Identity(), a * b, rotations), 0.99999f);
  }
}

TEST(LoadEBSD, EulerAnglesAreThoseOfBunge) {
  // phi1 turns around z, Phi around the new x, phi2 around the new z.
  const Eigen::Vector3f x = from_bunge(90 * kDegree, 0, 0) * Eigen::Vector3f::UnitX();
  EXPECT_NEAR((x - Eigen::Vector3f::UnitY()).norm(), 0, 1e-6);
  const Eigen::Vector3f z = from_bunge(90 * kDegree, 90 * kDegree, 0) * Eigen::Vector3f::UnitZ();
  EXPECT_NEAR((z - Eigen::Vector3f::UnitX()).norm(), 0, 1e-6);
  for (const Vec3& e : {Vec3(30, 50, 70), Vec3(200, 179, 359), Vec3(10, 1, 340), Vec3(0, 90, 0)}) {
    const Vec3 back = to_bunge(from_bunge(e[0] * kDegree, e[1] * kDegree, e[2] * kDegree));
    EXPECT_NEAR((back - e).norm(), 0, 2e-3) << e.transpose();
  }
  std::mt19937 g(3);
  for (int k = 0; k < 200; ++k) {
    const Q q = test::random_orientation(g);
    const Vec3 e = to_bunge(q) * kDegree;
    EXPECT_NEAR(std::abs(q.dot(from_bunge(e[0], e[1], e[2]))), 1, 1e-5);
  }
  for (const Q& q : {Q::Identity(), turned(180, {1, 0, 0}), turned(180, {0, 0, 1}), turned(180, {1, 1, 0})}) {
    const Vec3 e = to_bunge(q) * kDegree;
    EXPECT_NEAR(std::abs(q.dot(from_bunge(e[0], e[1], e[2]))), 1, 1e-5) << q.coeffs().transpose();
  }
}

TEST(LoadEBSD, DisorientationsAreKnownOnes) {
  using enum LaueGroup;
  EXPECT_NEAR(angle(Q::Identity(), turned(90, {0, 0, 1}), CubicHigh), 0, 0.1);
  EXPECT_NEAR(angle(Q::Identity(), turned(70.5288, {1, 1, 0}), CubicHigh), 60, 0.1);  // Σ3
  EXPECT_NEAR(angle(Q::Identity(), turned(45, {0, 0, 1}), CubicHigh), 45, 0.1);
  EXPECT_NEAR(angle(Q::Identity(), turned(90, {0, 0, 1}), CubicLow), 90, 0.1);
  EXPECT_NEAR(angle(Q::Identity(), turned(60, {0, 0, 1}), HexagonalHigh), 0, 0.1);
  EXPECT_NEAR(angle(Q::Identity(), turned(60, {0, 0, 1}), TrigonalHigh), 60, 0.1);
  EXPECT_NEAR(angle(Q::Identity(), turned(180, {0, 1, 0}), Monoclinic), 0, 0.1);
  EXPECT_NEAR(angle(Q::Identity(), turned(180, {0, 1, 0}), Triclinic), 180, 0.1);
  // Random pairs of cubic crystals: mean 40.74 degrees, at most 62.80 (Mackenzie 1958).
  std::mt19937 g(7);
  double sum = 0, most = 0;
  const auto rotations = Symmetry{CubicHigh}.rotations();
  for (int k = 0; k < 20000; ++k) {
    const Q a = test::random_orientation(g), b = test::random_orientation(g);
    const double d = 2 * std::acos(half_angle_cosine(a, b, rotations)) / kDegree;
    sum += d / 20000;
    most = std::max(most, d);
  }
  EXPECT_NEAR(sum, 40.74, 0.3);
  EXPECT_LT(most, 62.81);
  EXPECT_GT(most, 61);
}

TEST(LoadEBSD, EquivalentOrientationsHaveOneColor) {
  std::mt19937 g(5);
  for (const Symmetry& s : all_groups())
    for (int k = 0; k < 50; ++k) {
      const Q q = test::random_orientation(g);
      const Vec3f color = direction_color(q, s);
      EXPECT_NEAR(color.maxCoeff(), 1, 1e-6);
      for (const Q& r : s.rotations())
        EXPECT_LT((direction_color(q * r, s) - color).norm(), 0.02f) << name_of(s.group);
      EXPECT_GT(half_angle_cosine(closest(q, Q::Identity(), s.rotations()), q, s.rotations()), 0.9999f);
    }
  // The directions [001], [101] and [111] along the normal.
  const Symmetry cubic{LaueGroup::CubicHigh};
  const auto along = [](Eigen::Vector3f h) { return Q(Q::FromTwoVectors(h, Eigen::Vector3f::UnitZ())); };
  EXPECT_LT((direction_color(along({0, 1, 0}), cubic) - Vec3f(1, 0, 0)).norm(), 0.01f);
  EXPECT_LT((direction_color(along({-1, 0, 1}), cubic) - Vec3f(0, 1, 0)).norm(), 0.02f);
  EXPECT_LT((direction_color(along({1, -1, 1}), cubic) - Vec3f(0, 0, 1)).norm(), 0.02f);
  EXPECT_LT((direction_color(along({0, 0, -1}), {LaueGroup::HexagonalHigh}) - Vec3f(1, 0, 0)).norm(), 0.01f);
}

}  // namespace
}  // namespace terrazzo

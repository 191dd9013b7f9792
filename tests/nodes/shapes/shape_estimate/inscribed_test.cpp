#include "nodes/shapes/shape_estimate/inscribed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace terrazzo::shape_estimate {
namespace {

using std::numbers::pi;

// A regular polygon with corners rounded by `radius` (of its inscribed circle), stretched and turned.
std::vector<Vec2> rounded_polygon(int sides, double radius, double stretch) {
  std::vector<Vec2> out;
  constexpr int kArc = 60;
  for (int k = 0; k < sides; ++k)
    for (int i = 0; i <= kArc; ++i) {
      const double corner = 2 * pi * k / sides, at = corner + pi / sides * (2.0 * i / kArc - 1);
      const Vec2 middle = (1 - radius) / std::cos(pi / sides) * Vec2(std::cos(corner), std::sin(corner));
      const Vec2 p = middle + radius * Vec2(std::cos(at), std::sin(at));
      out.push_back(Eigen::Rotation2Dd(0.3) * Vec2(stretch * p.x(), p.y()));
    }
  return out;
}

TEST(InscribedShares, OfPolygonsAreOneFromTheirNumberOfCornersOn) {
  for (const double stretch : {1.0, 2.5}) {
    const auto triangle = inscribed_shares(rounded_polygon(3, 0, stretch)),
               square = inscribed_shares(rounded_polygon(4, 0, stretch)),
               hexagon = inscribed_shares(rounded_polygon(6, 0, stretch));
    for (const double share : triangle) EXPECT_NEAR(share, 1, 1e-9);
    EXPECT_NEAR(square[0], 0.5, 1e-9);
    EXPECT_NEAR(square[1], 1, 1e-9);
    EXPECT_NEAR(square[2], 1, 1e-9);
    EXPECT_NEAR(hexagon[0], 0.5, 1e-9);
    EXPECT_NEAR(hexagon[1], 2.0 / 3, 1e-9);
    EXPECT_NEAR(hexagon[2], 1, 1e-9);
  }
}

TEST(InscribedShares, OfEllipsesAreKnown) {
  for (const double stretch : {1.0, 3.0}) {
    const auto shares = inscribed_shares(rounded_polygon(4, 1, stretch));
    for (std::size_t i = 0; i < kInscribed.size(); ++i)
      EXPECT_NEAR(shares[i], kInscribed[i] * std::sin(2 * pi / kInscribed[i]) / (2 * pi), 0.002);
  }
}

// Corners count in proportion to their radius.
TEST(InscribedShares, FallWithTheRadiusOfCorners) {
  const double sharp = inscribed_shares(rounded_polygon(4, 0.05, 1))[1],
               round = inscribed_shares(rounded_polygon(4, 0.1, 1))[1];
  EXPECT_LT(sharp, 0.98);
  EXPECT_NEAR((1 - round) / (1 - sharp), 2, 0.2);
}

TEST(InscribedShares, OfNothingAreNothing) {
  for (const double share : inscribed_shares({})) EXPECT_EQ(share, 0);
  for (const double share : inscribed_shares({{0, 0}, {1, 1}, {2, 2}})) EXPECT_EQ(share, 0);
}

}  // namespace
}  // namespace terrazzo::shape_estimate

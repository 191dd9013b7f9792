// Distances and local thickness against their definitions and closed forms.
#include "nodes/packing/measure3d/thickness.h"

#include <gtest/gtest.h>

#include <numeric>

#include "nodes/packing/measure3d/distance.h"
#include "tests/nodes/packing/measure3d/blocks.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace measure3d;

// Squared distance in mm² of two voxels, or of their nearest images.
double square_between(const Classes& c, std::size_t i, std::size_t j) {
  const auto place = [&](std::size_t k) {
    const auto nx = static_cast<std::size_t>(c.box.size.x()), ny = static_cast<std::size_t>(c.box.size.y());
    return Vec3(static_cast<double>(k % nx), static_cast<double>(k / nx % ny),
                static_cast<double>(k / nx / ny));
  };
  Vec3 d = place(i) - place(j);
  if (c.box.periodic) d = nearest_image(d, c.box.size.cast<double>());
  return d.cwiseProduct(c.box.spacing).squaredNorm();
}

std::vector<double> squares_by_definition(const Classes& c) {
  std::vector<double> out(c.of.size(), INFINITY);
  for (std::size_t i = 0; i < out.size(); ++i)
    for (std::size_t j = 0; j < out.size(); ++j)
      if (c.of[i] != c.of[j]) out[i] = std::min(out[i], square_between(c, i, j));
  return out;
}

// In whole boxes of sizes odd and even, with voxels of three lengths, and blobs larger than half of a period.
TEST(Measure3DThickness, AndDistanceAreWhatTheirDefinitionsSay) {
  int cases = 0;
  for (const bool periodic : {true, false})
    for (const Vec3& spacing : {Vec3(1, 1, 1), Vec3(0.5, 0.4, 0.7)})
      for (const int edge : {1, 3, 5}) {
        const auto c =
            test::classes_of({11, 8, 9}, spacing, periodic, test::random_labels(edge == 5 ? 2 : 3, edge, 7));
        const auto squares = squares_by_definition(c);
        const auto found = squared_distances(c, test::kPlenty, {});
        const auto thickness = local_thickness(c, test::kPlenty, {});
        const double unit = spacing.minCoeff();
        for (std::size_t i = 0; i < squares.size(); ++i) {
          ASSERT_NEAR(found[i] * unit * unit, squares[i], 1e-5 * squares[i]) << i;
          double most = 0;
          for (std::size_t j = 0; j < squares.size(); ++j)
            if (c.of[j] == c.of[i] && square_between(c, i, j) < squares[j] * (1 - 1e-6))
              most = std::max(most, squares[j]);
          ASSERT_NEAR(thickness[i], 2 * std::sqrt(most), 1e-5 * std::sqrt(most)) << i;
        }
        ++cases;
      }
  EXPECT_EQ(cases, 12);
}

TEST(Measure3DThickness, OfPlatesIsTheirWidth) {
  for (int axis = 0; axis < 3; ++axis)
    for (const int width : {6, 7, 12}) {
      const auto c = test::classes_of({24, 24, 24}, Vec3::Constant(0.1), true, [&](int x, int y, int z) {
        return (Vec3i(x, y, z)[axis] + 3) % 24 < width ? 1 : 0;
      });
      const auto found = thickness_distributions(c, local_thickness(c, test::kPlenty, {}), {});
      // A plate of an odd number of voxels has one more.
      EXPECT_NEAR(found[1].mean, 0.1 * (width + width % 2), 1e-6);
      EXPECT_NEAR(found[0].mean, 0.1 * (24 - width + width % 2), 1e-6);
      EXPECT_NEAR(found[1].deviation, 0, 1e-4);
      ASSERT_FALSE(found[1].share.empty());
      EXPECT_NEAR(found[1].share.back(), 1, 1e-12);
    }
}

TEST(Measure3DThickness, OfBallsAndRodsIsTheirDiameter) {
  const Vec3 spacing(0.5, 0.4, 0.6);
  for (const double radius : {4.0, 5.3}) {
    const auto near = [&](int x, int y, int z, bool rod) {
      Vec3 d = nearest_image((Vec3(x, y, z) + Vec3::Constant(0.5)).cwiseProduct(spacing) - Vec3(1.1, 8, 9.2),
                             Vec3(16, 16, 18));
      if (rod) d.y() = 0;
      return d.norm() < radius ? 1 : 0;
    };
    for (const bool rod : {false, true}) {
      const auto c = test::classes_of({32, 40, 30}, spacing, true,
                                      [&](int x, int y, int z) { return near(x, y, z, rod); });
      const auto found = thickness_distributions(c, local_thickness(c, test::kPlenty, {}), {})[1];
      EXPECT_NEAR(found.edges.back(), 2 * radius, 1.2);  // the largest ball, to two voxels
      EXPECT_NEAR(found.mean / (2 * radius), 1, 0.08);   // edges of voxels are thinner
      EXPECT_LT(found.deviation / (2 * radius), 0.12);
    }
  }
}

// The share of the volume from a diameter on is what an opening by balls of this diameter leaves.
TEST(Measure3DThickness, SharesAreTheGranulometry) {
  const auto c = test::classes_of({40, 40, 40}, Vec3::Ones(), true, [&](int x, int y, int z) {
    const Vec3 p(x, y, z), edge = Vec3::Constant(40);
    const double large = nearest_image(p - Vec3(1, 2, 3), edge).norm(),
                 small = nearest_image(p - Vec3(20, 20, 22), edge).norm();
    return large < 9.5 || small < 5.5 ? 1 : 0;
  });
  const auto found = thickness_distributions(c, local_thickness(c, test::kPlenty, {}), {})[1];
  EXPECT_NEAR(std::accumulate(found.share.begin(), found.share.end(), 0.0), 1, 1e-9);
  const auto left = [&](double radius) {
    double share = 0;
    for (std::size_t b = 0; b < found.share.size(); ++b)
      if (found.edges[b] >= 2 * radius - 1e-9) share += found.share[b];
    return share;
  };
  // Between the sizes of the balls, the larger one is left.
  for (const double radius : {6.5, 7.5}) EXPECT_NEAR(left(radius), 857.4 / (857.4 + 166.4), 0.01) << radius;
  EXPECT_EQ(left(10.5), 0);
}

TEST(Measure3DThickness, IsZeroWhereItIsNotWantedOrNotKnown) {
  auto c = test::classes_of({8, 8, 8}, Vec3::Ones(), true, test::random_labels(2, 3, 1));
  c.wanted[0] = 0;
  const auto some = local_thickness(c, test::kPlenty, {});
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(some[i] > 0, c.of[i] == 1);
  const auto one = test::classes_of({8, 8, 8}, Vec3::Ones(), true, [](int, int, int) { return 0; });
  const auto none = local_thickness(one, test::kPlenty, {});
  EXPECT_EQ(*std::max_element(none.begin(), none.end()), 0);
  EXPECT_TRUE(std::isnan(thickness_distributions(one, none, {})[0].mean));
  EXPECT_EQ(test::code_of([&] { local_thickness(c, 20 * 512 - 1, {}); }), "too-large");
  EXPECT_EQ(test::code_of([&] { squared_distances(c, 4 * 512 - 1, {}); }), "too-large");
}

}  // namespace
}  // namespace terrazzo

// Normals, occlusion and rounded edges of height fields against closed forms.
#include "nodes/textures/relief/height_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/geometry/periodic.h"
#include "runtime/random.h"

namespace terrazzo::textures {
namespace {

template <class Height>
HeightField field_of(int width, int height, double mm, const Height& at) {
  HeightField h{width, height, mm, mm, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      h.mm.push_back(static_cast<float>(at((x + 0.5) * mm, (height - y - 0.5) * mm)));  // y upwards
  return h;
}

HeightField rough(int width, int height) {
  return field_of(width, height, 0.1, [](double x, double y) {
    return Random(3, 1, static_cast<std::uint64_t>(round_nearest(100 * x + 100000 * y))).uniform(0, 0.3);
  });
}

TEST(HeightField, NormalsOfASphereAreThoseOfTheSphere) {
  const double radius = 1;
  const HeightField h = field_of(256, 256, 0.01, [&](double x, double y) {
    const double square = radius * radius - (x - 1.28) * (x - 1.28) - (y - 1.28) * (y - 1.28);
    return square > 0 ? std::sqrt(square) : 0;
  });
  const Image normals = normal_map(h);
  double worst = 0;
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      const Vec3 true_normal((x + 0.5) * 0.01 - 1.28, (256 - y - 0.5) * 0.01 - 1.28, h.at(x, y));
      if (true_normal.head<2>().norm() > 0.8 * radius) continue;  // 53°
      const Vec3 n = (2 * normals.at(x, y) - Vec3f::Ones()).cast<double>();
      worst = std::max(worst, std::acos(std::min(1.0, n.dot(true_normal.normalized()))));
    }
  EXPECT_LT(worst, 0.001);  // radians; a step of 8 bits is 0.008
}

TEST(HeightField, ThePlaneIsFlatAndOpen) {
  const HeightField h = field_of(8, 4, 1, [](double, double) { return 2.5; });
  for (const Vec3f& n : normal_map(h).pixels) EXPECT_EQ(n, Vec3f(0.5f, 0.5f, 1));
  for (const Vec3f& o : occlusion_map(h).pixels) EXPECT_EQ(o, Vec3f::Ones());
}

TEST(HeightField, APitSeesTheSkyOfItsOpening) {
  for (const double depth : {0.2, 0.5, 1.0}) {
    const double radius = 0.5;
    const HeightField h = field_of(201, 201, 0.01, [&](double x, double y) {
      return std::hypot(x - 1.005, y - 1.005) < radius ? -depth : 0;
    });
    const double open = radius * radius / (radius * radius + depth * depth);
    EXPECT_NEAR(occlusion_map(h).at(100, 100).x(), open, 0.04) << depth;
  }
}

TEST(HeightField, ASlopeSeesAllOfItsHemisphere) {
  // A wide roof: away from its ridge and its valley, nothing stands above the slope but the other slope.
  const HeightField h = field_of(400, 4, 0.01, [](double x, double) { return 0.2 * std::abs(x - 2); });
  EXPECT_GT(occlusion_map(h).at(5, 0).x(), 0.99);
}

TEST(HeightField, ABallRoundsConvexEdgesOnly) {
  const double height = 1, radius = 0.5;
  HeightField h = field_of(400, 8, 0.01, [&](double x, double) { return x > 1 && x < 3 ? height : 0; });
  round_edges(h, radius);
  for (int x = 0; x < 200; ++x) {
    const double from = (x + 0.5) * 0.01 - 1;  // from the edge
    const double drop =
        from < radius ? radius - std::sqrt(radius * radius - (radius - from) * (radius - from)) : 0;
    if (from < 0)
      EXPECT_EQ(h.at(x, 3), 0.0f) << x;
    else if (from > 0.03)  // steeper than the texels can show
      EXPECT_NEAR(h.at(x, 3), height - drop, 0.03) << x;
  }
}

TEST(HeightField, OppositeEdgesJoin) {
  const int width = 48, height = 32, dx = 17, dy = 9;
  const HeightField h = rough(width, height);
  HeightField moved = h;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      moved.mm[pixel_at((x + dx) % width, (y + dy) % height, width)] = h.at(x, y);
  const auto expect_moved = [&](const Image& a, const Image& b) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) ASSERT_EQ(a.at(x, y), b.at((x + dx) % width, (y + dy) % height));
  };
  expect_moved(normal_map(h), normal_map(moved));
  expect_moved(occlusion_map(h), occlusion_map(moved));
  HeightField a = h, b = moved;
  round_edges(a, 0.35);
  round_edges(b, 0.35);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) ASSERT_EQ(a.at(x, y), b.at((x + dx) % width, (y + dy) % height));
}

}  // namespace
}  // namespace terrazzo::textures

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

TEST(HeightField, AParaboloidRoundsConvexEdgesOnly) {
  // Over a step of H, the paraboloids whose apex is at the top and that touch the foot end √(2 R H) inside.
  const double step = 1, radius = 0.5;
  for (const double depth : {1.0, 7.0}) {  // below the floor, holes of any depth have the same rim
    HeightField h =
        field_of(400, 8, 0.01, [&](double x, double) { return x > 1 && x < 3 ? step : step - depth; });
    const HeightField before = h;
    round_edges(h, radius, 0);
    for (int x = 0; x < 200; ++x) {
      const double from = (x + 0.5) * 0.01 - 0.995;  // from the last texel of the foot
      const double round = from * std::sqrt(2 * step / radius) - from * from / (2 * radius);
      if (from < 0.005)
        EXPECT_EQ(h.at(x, 3), before.at(x, 3)) << x;
      else
        EXPECT_NEAR(h.at(x, 3), from < std::sqrt(2 * radius * step) ? round : step, 0.002) << x;
    }
  }
}

// The definition, point by point: min over all places, then max.
TEST(HeightField, RoundedEdgesAreAnOpening) {
  const int width = 24, height = 18;
  for (const double radius : {0.15, 1.0, 1e9}) {
    const HeightField h = rough(width, height);
    const auto drop = [&](int dx, int dy) {
      dx = std::min(std::abs(dx), width - std::abs(dx));
      dy = std::min(std::abs(dy), height - std::abs(dy));
      return (dx * dx + dy * dy) * 0.01 / (2 * radius);
    };
    std::vector<double> low(h.mm.size(), 1e9), high(h.mm.size(), -1e9);
    const auto each = [&](auto&& visit) {
      for (int a = 0; a < width * height; ++a)
        for (int b = 0; b < width * height; ++b)
          visit(a, b, drop(a % width - b % width, a / width - b / width));
    };
    each([&](int a, int b, double d) { low[a] = std::min(low[a], double{h.mm[b]} + d); });
    each([&](int a, int b, double d) { high[a] = std::max(high[a], low[b] - d); });
    HeightField rounded = h;
    round_edges(rounded, radius, -1);
    for (std::size_t i = 0; i < high.size(); ++i) ASSERT_NEAR(rounded.mm[i], high[i], 1e-6) << radius;
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
  round_edges(a, 0.35, -1);
  round_edges(b, 0.35, -1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) ASSERT_EQ(a.at(x, y), b.at((x + dx) % width, (y + dy) % height));
}

}  // namespace
}  // namespace terrazzo::textures

#include "nodes/detail/detail_solid/light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/texture/color.h"
#include "nodes/detail/detail_solid/rim.h"
#include "nodes/detail/residual/outline_depth.h"
#include "runtime/random.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

// Disks that are lighter on their upper side by `light` at one radius, and the shadow below them: 0.08 in the
// binder's next 6 pixels, with the cosine to the normal.
test::DrawnPicture lit_disks(float light, float shadow) {
  return test::draw_disks(400, 80, 28, [=](int x, int y, int id) {
    const double dx = x % 80 + 0.5 - 40, up = 40 - (y % 80 + 0.5), d = std::hypot(dx, up);
    const float grain = 0.004f * static_cast<float>((x * 7 + y * 13) % 5 - 2);
    float v = 0.5f + grain;
    if (id > 0) v += light * static_cast<float>(up / 28) - 0.15f;
    if (id == 0 && d < 34) v += shadow * static_cast<float>(up / d);
    return Vec3f(Vec3f::Constant(v));
  });
}

Detail light_of(const test::DrawnPicture& drawn, Phases* left = nullptr) {
  PhaseOptions choice;
  choice.groups = 1;
  choice.edge = 0;
  choice.specks = 0;
  Phases p = find_phases(drawn.image, drawn.labels, choice);
  Detail d;
  d.pixel_size = 0.1;
  d.phases.resize(p.pixels.size());
  split_rims(p, drawn.labels, d);
  split_light(p, drawn.labels, d);
  if (left) *left = std::move(p);
  return d;
}

TEST(DetailLight, UpperSidesAndShadowsAreFound) {
  Phases left;
  const Detail d = light_of(lit_disks(0.1f, 0.08f), &left);
  ASSERT_EQ(d.phases.size(), 2u);
  // Offsets of particles are relative to their lightness of 0.35, as Detail says.
  EXPECT_NEAR(d.phases[1].tilt.y(), 0.1f / 0.5f, 0.02f);
  EXPECT_NEAR(d.phases[1].tilt.x(), 0, 0.005f);
  ASSERT_EQ(d.phases[0].rims.size(), 1u);
  const Detail::Rim& rim = d.phases[0].rims[0];
  ASSERT_EQ(rim.up.size(), rim.offset.size());
  EXPECT_NEAR(rim.up[2].x(), 0.08f, 0.01f);
  EXPECT_NEAR(rim.up[14].x(), 0, 0.01f);
  EXPECT_NEAR(rim.right[2].x(), 0, 0.01f);
  // What is left does not depend on the side.
  double above = 0, below = 0;
  for (std::size_t i = 0; i < left.phase.size(); ++i) {
    if (left.phase[i] != 1) continue;
    const int y = static_cast<int>(i / 400) % 80;
    (y < 40 ? above : below) += left.offset[i].x();
  }
  EXPECT_NEAR(above, below, 0.01 * 400 * 400 / 4);
}

TEST(DetailLight, WithoutLightThereIsNone) {
  // Each disk has a slope of its own, in a direction of its own.
  Random random(7);
  std::vector<Vec3f> slope(64);
  for (Vec3f& s : slope) {
    const double a = random.uniform(0, 6.2832);
    s = Vec3(0.1 * std::cos(a), 0.1 * std::sin(a), 0).cast<float>();
  }
  const auto drawn = test::draw_disks(640, 80, 28, [&](int x, int y, int id) {
    const auto dx = static_cast<float>(x % 80 + 0.5 - 40), dy = static_cast<float>(y % 80 + 0.5 - 40);
    float v = id > 0 ? 0.35f : 0.5f;
    if (id > 0)
      v += (slope[static_cast<std::size_t>(id) - 1].x() * dx +
            slope[static_cast<std::size_t>(id) - 1].y() * dy) /
           28;
    return Vec3f(Vec3f::Constant(v));
  });
  const Detail d = light_of(drawn);
  EXPECT_LT(d.phases[1].tilt.norm(), 0.3f * 0.2f) << "each disk has 0.2";
}

TEST(DetailLight, TwoProfilesTellNothing) {
  auto drawn = lit_disks(0.1f, 0.08f);
  for (auto& id : drawn.labels.ids)
    if (id > 2) id = 0;
  drawn.labels.classes.resize(2);
  const Detail d = light_of(drawn);
  for (std::size_t k = 1; k < d.phases.size(); ++k) EXPECT_EQ(d.phases[k].tilt.norm(), 0);
  for (const auto& rim : d.phases[0].rims) EXPECT_TRUE(rim.up.empty());
}

TEST(OutlineNormals, PointOutwards) {
  const auto drawn = test::draw_disks(160, 160, 50, [](int, int, int) { return Vec3f(Vec3f::Zero()); });
  const auto outlines = residual::nearest_outlines(drawn.labels.ids.data(), 160, 160, false);
  for (int y = 10; y < 150; ++y)
    for (int x = 10; x < 150; ++x) {
      const Eigen::Vector2f away(static_cast<float>(x + 0.5 - 80), static_cast<float>(80 - y - 0.5));
      if (away.norm() < 10) continue;  // outlines on all sides
      const Eigen::Vector2f& n = outlines.normal[static_cast<std::size_t>(y) * 160 + x];
      ASSERT_GT(n.dot(away.normalized()), 0.9f) << x << ", " << y;
      ASSERT_LE(n.norm(), 1.0001f);
    }
  EXPECT_LT(outlines.normal[80 * 160 + 80].norm(), 0.5f) << "the center is equally near to all sides";
}

}  // namespace
}  // namespace terrazzo

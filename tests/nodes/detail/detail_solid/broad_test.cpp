#include "nodes/detail/detail_solid/broad.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/texture/color.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

// White specks of 2 × 2 pixels in black disks: the disks stay black, and no speck has a halo.
TEST(DetailBroad, SpecksStayWholeInTheFinePart) {
  const auto speck = [](int x, int y) { return x % 17 < 2 && y % 17 < 2; };
  const auto drawn = test::draw_disks(320, 80, 30, [&](int x, int y, int id) {
    return Vec3f(Vec3f::Constant(id == 0 ? 0.5f : speck(x, y) ? 0.9f : 0.02f));
  });
  PhaseOptions choice;
  choice.groups = 1;
  Phases p = find_phases(drawn.image, drawn.labels, choice);
  for (const Vec3f& c : p.profile_color) EXPECT_NEAR(linear_to_srgb(c).x(), 0.02f, 0.01f);
  const std::vector<Vec3f> before = p.offset, broad = split_broad(p, drawn.labels);
  int specks = 0;
  for (std::size_t i = 0; i < p.phase.size(); ++i) {
    if (p.phase[i] != 1) continue;
    ASSERT_LT(broad[i].norm(), 0.01f) << i;
    ASSERT_LT((p.offset[i] - before[i]).norm(), 0.01f) << i;
    specks += p.offset[i].x() > 0.5f;
  }
  EXPECT_GT(specks, 400);
}

// A dark zone as wide as a disk's radius is no speck.
TEST(DetailBroad, ZonesBelongToTheBroadPart) {
  const auto drawn = test::draw_disks(320, 80, 30, [](int x, int y, int id) {
    const float grain = 0.01f * static_cast<float>((x * 7 + y * 13) % 5 - 2);
    return Vec3f(Vec3f::Constant(id == 0 ? 0.5f : (x % 80 < 25 ? 0.2f : 0.7f) + grain));
  });
  PhaseOptions choice;
  choice.groups = 1;
  Phases p = find_phases(drawn.image, drawn.labels, choice);
  const std::vector<Vec3f> broad = split_broad(p, drawn.labels);
  double dark = 0, count = 0;
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] == 1 && i % 320 % 80 < 17) dark += p.offset[i].x(), ++count;
  ASSERT_GT(count, 100);
  // Of −0.5 relative to the color, only the phase's mean stays in the fine part.
  EXPECT_NEAR(dark / count, 0, 0.2);
}

// The binder of asphalt: air and mastic, sharpened so that a pixel beside the edge belongs to neither.
TEST(DetailBroad, EdgesBetweenZonesAreNoGrain) {
  const auto drawn = test::draw_disks(320, 80, 20, [](int x, int y, int id) {
    const float grain = 0.01f * static_cast<float>((x * 7 + y * 13) % 5 - 2);
    const bool mastic = (x + 10) / 80 % 2 == 0;
    const float binder = !mastic ? 0.05f : (x + 10) % 80 == 0 ? 0.38f : 0.3f;
    return Vec3f(Vec3f::Constant((id == 0 ? binder : 0.8f) + grain));
  });
  PhaseOptions choice;
  choice.groups = 1;
  choice.specks = 0;
  Phases p = find_phases(drawn.image, drawn.labels, choice);
  const std::size_t used = p.pixels[0];
  split_broad(p, drawn.labels);
  EXPECT_LT(p.pixels[0], used);
  EXPECT_GT(p.pixels[0], used * 9 / 10);
  Mean mean;
  for (std::size_t i = 0; i < p.phase.size(); ++i)
    if (p.phase[i] == 0) mean.add(p.offset[i]);
  std::size_t counted = 0;
  float most = 0;  // a Gaussian filter leaves half of the step of 0.25
  for (std::size_t i = 0; i < p.phase.size(); ++i) {
    if (p.phase[i] != 0) continue;
    most = std::max(most, (p.offset[i] - mean.value()).cwiseAbs().maxCoeff()), ++counted;
  }
  EXPECT_EQ(counted, p.pixels[0]);
  EXPECT_LT(most, 0.07f);
}

}  // namespace
}  // namespace terrazzo

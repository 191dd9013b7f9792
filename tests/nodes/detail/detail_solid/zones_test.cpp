#include "nodes/detail/detail_solid/zones.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "nodes/detail/residual/wave_field.h"
#include "runtime/random.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

float noise(int x, int y) {
  return static_cast<float>(Random(9, 1, static_cast<std::uint64_t>(y) * 4096 + x).normal());
}

struct Split {
  Phases phases;
  Detail detail;
};

template <class Color>
Split split(Color&& color, int size = 480, int step = 120, double radius = 30) {
  const auto drawn = test::draw_disks(size, step, radius, color);
  PhaseOptions choice;
  choice.specks = 0;
  Split out{find_phases(drawn.image, drawn.labels, choice), {}};
  out.detail.phases.resize(out.phases.pixels.size());
  split_zones(out.phases, drawn.labels, out.detail, 1);
  split_zone_contrasts(out.phases, out.detail);
  return out;
}

// Zones of a known Gaussian field, 0.2 and 0.6 with grain of 0.01 and 0.03.
TEST(DetailZones, TwoLevelsAreFoundWithTheirField) {
  const residual::WaveField field(std::array{12.0f}, std::array{1.0f}, Vec3(480, 480, 480));
  const auto dark = [&](int x, int y) {
    return field.at({static_cast<float>(x), static_cast<float>(y), 5}) < 0.3f;
  };
  const Split s = split([&](int x, int y, int id) {
    const float v = id ? 0.9f : dark(x, y) ? 0.2f + 0.01f * noise(x, y) : 0.6f + 0.03f * noise(x, y);
    return Vec3f(Vec3f::Constant(v));
  });
  const Detail::Zones& z = s.detail.zones;
  ASSERT_FALSE(z.level.empty());
  EXPECT_NEAR(z.light.x() - z.dark.x(), 0.4f, 0.01f);
  for (const float l : z.level) EXPECT_NEAR(l, 0.3f, 0.5f);
  EXPECT_NEAR(z.light_contrast / z.dark_contrast, 3, 0.2);
  // Its covariance at the distance where that of the true field is one half.
  const double half = 12 * std::sqrt(4 * std::log(2.0));
  double there = 0;
  for (std::size_t k = 0; k < z.sigma.size(); ++k)
    there += static_cast<double>(z.variance[k]) * std::exp(-half * half / (4.0 * z.sigma[k] * z.sigma[k]));
  EXPECT_NEAR(there, 0.5, 0.12);
  // What is left has the same deviation everywhere and mean zero.
  double sum[2] = {0, 0}, square[2] = {0, 0}, n[2] = {0, 0};
  for (std::size_t i = 0; i < s.phases.zone.size(); ++i)
    if (const int k = s.phases.zone[i]; k > 0 && s.phases.phase[i] == 0) {
      const double v = s.phases.offset[i].x();
      sum[k - 1] += v, square[k - 1] += v * v, ++n[k - 1];
    }
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(sum[k] / n[k], 0, 0.002);
  EXPECT_NEAR(std::sqrt(square[1] / n[1]) / std::sqrt(square[0] / n[0]), 1, 0.05);
}

// A light coat of ten pixels around each disk.
TEST(DetailZones, LevelsDependOnTheDistance) {
  const Split s = split([&](int x, int y, int id) {
    const double r = std::hypot(x % 120 - 59.5, y % 120 - 59.5);
    return Vec3f(Vec3f::Constant((id ? 0.9f : r < 42 ? 0.6f : 0.2f) + 0.02f * noise(x, y)));
  });
  ASSERT_FALSE(s.detail.zones.level.empty());
  EXPECT_LT(s.detail.zones.level[5], -1.5f);
  EXPECT_GT(s.detail.zones.level[25], 1.5f);
}

// Air in gaps wider than the mastic reaches, whatever the distance from the disks.
TEST(DetailZones, LevelsDependOnTheWidth) {
  // Columns of disks of radius 50 lie 20 pixels apart, rows a whole column: narrow and wide gaps.
  const auto drawn = test::draw_disks(480, 120, 50, [&](int x, int y, int id) {
    const bool wide = y % 240 >= 120;
    return Vec3f(Vec3f::Constant((id ? 0.9f : wide ? 0.2f : 0.6f) + 0.02f * noise(x, y)));
  });
  Labels labels = drawn.labels;
  for (std::size_t i = 0; i < labels.ids.size(); ++i)
    if (i / 480 % 240 >= 120) labels.ids[i] = 0;  // no disks in every second row
  Image image = drawn.image;
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    if (i / 480 % 240 >= 120) image.pixels[i] = srgb_to_linear(Vec3f::Constant(0.2f));
  PhaseOptions choice;
  choice.specks = 0;
  Phases phases = find_phases(image, labels, choice);
  Detail detail;
  detail.phases.resize(phases.pixels.size());
  split_zones(phases, labels, detail, 1);
  ASSERT_FALSE(detail.zones.level.empty());
  EXPECT_LT(detail.zones.level_by_width[10], -0.5f);
  EXPECT_GT(detail.zones.level_by_width[60], 0.5f);
}

TEST(DetailZones, GrainAndSmoothChangesAreNone) {
  // Noise of one level.
  EXPECT_TRUE(split([](int x, int y, int id) {
                return Vec3f(Vec3f::Constant((id ? 0.9f : 0.4f) + 0.05f * noise(x, y)));
              }).detail.zones.level.empty());
  // A ramp.
  EXPECT_TRUE(split([](int x, int, int id) {
                return Vec3f(Vec3f::Constant(id ? 0.9f : 0.2f + 0.4f * static_cast<float>(x) / 480));
              }).detail.zones.level.empty());
  // Salt and pepper of two pixels.
  EXPECT_TRUE(split([](int x, int y, int id) {
                return Vec3f(Vec3f::Constant(id ? 0.9f : noise(x / 2, y / 2) < 0 ? 0.2f : 0.6f));
              }).detail.zones.level.empty());
}

}  // namespace
}  // namespace terrazzo

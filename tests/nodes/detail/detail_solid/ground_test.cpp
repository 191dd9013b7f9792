#include "nodes/detail/detail_solid/ground.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "nodes/data/indices.h"
#include "runtime/random.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

// Stones in soil whose left half is lighter.
test::DrawnPicture stones_in_soil() {
  return test::draw_disks(320, 80, 24, [](int x, int y, int id) {
    if (id > 0) return Vec3f(0.9F, 0.9F, 0.9F);
    return Vec3f(Vec3f::Constant((x < 160 ? 0.5F : 0.4F) + 0.01F * static_cast<float>((x * 7 + y * 13) % 5)));
  });
}

Profiles surface_of(double covered) {
  Profiles p;
  p.view = View::Surface;
  p.area_fraction = covered;
  p.binder_color = Vec3f::Constant(0.2F);
  Profile q;
  q.area = q.whole = 1;
  q.color = Vec3f::Constant(0.2F);
  p.profiles.assign(16, q);
  return p;
}

TEST(Ground, ShowsSoilAndNoStones) {
  const test::DrawnPicture drawn = stones_in_soil();
  const Detail::Ground ground = find_ground(drawn.image, drawn.labels, nullptr, surface_of(0.28), 1);
  ASSERT_FALSE(ground.shade.empty());
  const float lightest = std::log((srgb_to_linear(Vec3f::Constant(0.54F)).x() + 0.01F) /
                                  (srgb_to_linear(Vec3f::Constant(0.4F)).x() + 0.01F));
  double mean = 0;
  for (const Vec3f& v : ground.shade) {
    EXPECT_LE(std::abs(v.x()), lightest + 1e-4F);
    mean += v.x() / ground.shade.size();
  }
  EXPECT_NEAR(mean, 0, 0.05);  // of logarithms: a little below that of colors
}

// Mean difference of luminance from one pixel to the next one, across the edges or inside.
double mean_step(const Detail::Ground& ground, bool edges) {
  double sum = 0, count = 0;
  for (int y = 0; y < ground.height; ++y)
    for (int x = 0; x < ground.width; ++x)
      for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{0, 1}}) {
        const bool over = x + dx == ground.width || y + dy == ground.height;
        if (over != edges) continue;
        const int u = (x + dx) % ground.width, v = (y + dy) % ground.height;
        sum += std::abs(ground.shade[pixel_at(x, y, ground.width)].x() -
                        ground.shade[pixel_at(u, v, ground.width)].x());
        ++count;
      }
  return sum / count;
}

TEST(Ground, ContinuesAtTheOppositeEdge) {
  const test::DrawnPicture drawn = test::draw_disks(320, 80, 24, [](int x, int y, int) {
    return Vec3f(
        Vec3f::Constant(static_cast<float>(0.5 + 0.1 * std::sin(x / 5.0) + 0.1 * std::sin(y / 7.0))));
  });
  const Detail::Ground ground = find_ground(drawn.image, drawn.labels, nullptr, surface_of(0.28), 1);
  ASSERT_GT(ground.width, 240);
  ASSERT_GT(ground.height, 240);
  EXPECT_LT(mean_step(ground, true), 1.5 * mean_step(ground, false));
}

// To the right of each stone, the soil has a fifth of the light.
TEST(Ground, HasNoShadowsOfStones) {
  const auto shadowed = [](bool shadows) {
    const test::DrawnPicture drawn = test::draw_disks(320, 80, 24, [&](int x, int y, int id) {
      const double dx = x % 80 + 0.5 - 40, dy = y % 80 + 0.5 - 40;
      const bool dark = shadows && id == 0 && dx > 0 && std::hypot(dx - 6, dy) < 24;
      const float grain = static_cast<float>(Random(1, 1, pixel_at(x, y, 320)).uniform() - 0.5);
      return linear_to_srgb(Vec3f::Constant((dark ? 0.04F : 0.2F) * std::exp(0.3F * grain)));
    });
    const Detail::Ground ground = find_ground(drawn.image, drawn.labels, nullptr, surface_of(0.28), 1);
    double darkest = 0;
    for (const Vec3f& v : ground.shade) darkest = std::min<double>(darkest, v.x());
    return darkest;
  };
  EXPECT_NEAR(shadowed(true), shadowed(false), 0.05);
}

// The window with most soil lies in the shade and is darker than most soil of the photograph.
TEST(Ground, MayBeInTheShadeAsAWhole) {
  test::DrawnPicture drawn = test::draw_disks(1600, 80, 30, [](int x, int y, int) {
    return linear_to_srgb(Vec3f::Constant(x < 700 && y < 800 ? 0.03F : 0.3F));
  });
  for (int y = 0; y < 800; ++y)
    for (int x = 0; x < 640; ++x) drawn.labels.ids[drawn.labels.index(x, y)] = 0;
  const Detail::Ground ground = find_ground(drawn.image, drawn.labels, nullptr, surface_of(0.28), 1);
  ASSERT_FALSE(ground.shade.empty());
  for (const Vec3f& v : ground.shade) ASSERT_NEAR(v.x(), 0, 0.01);
}

TEST(Ground, IsOfSurfacesWithSoil) {
  const test::DrawnPicture drawn = stones_in_soil();
  EXPECT_TRUE(find_ground(drawn.image, drawn.labels, nullptr, surface_of(0.9), 1).shade.empty());  // loose
  Labels all = drawn.labels;
  std::fill(all.ids.begin(), all.ids.end(), 1);
  EXPECT_TRUE(find_ground(drawn.image, drawn.labels, &all, surface_of(0.28), 1).shade.empty());  // no soil
  Profiles cut = surface_of(0.28);
  cut.view = View::Section;
  EXPECT_TRUE(find_ground(drawn.image, drawn.labels, nullptr, cut, 1).shade.empty());
  EXPECT_TRUE(find_tones(drawn.image, nullptr, cut).empty());
  EXPECT_TRUE(find_tones(drawn.image, &all, surface_of(0.28)).empty());
}

TEST(Tones, AreQuantilesOfTheLuminance) {
  Image image(100, 100, 1, 0.1);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = Vec3f::Constant(static_cast<float>(i) / (image.pixels.size() - 1));
  const std::vector<float> tones = find_tones(image, nullptr, surface_of(0.5));
  ASSERT_EQ(tones.size(), 101U);
  for (int k = 0; k <= 100; ++k) EXPECT_NEAR(tones[k], k / 100.0, 1e-3);
  Labels mask;  // the dark half is undecided, and the light quarter of a card is ignored
  mask.width = mask.height = 100;
  mask.ids.assign(10000, 2);
  std::fill(mask.ids.begin() + 5000, mask.ids.begin() + 7500, 0);
  std::fill(mask.ids.begin() + 7500, mask.ids.end(), 1);
  EXPECT_NEAR(find_tones(image, &mask, surface_of(0.5)).front(), 0, 1e-3);
  EXPECT_NEAR(find_tones(image, &mask, surface_of(0.5)).back(), 0.75, 1e-3);
}

}  // namespace
}  // namespace terrazzo

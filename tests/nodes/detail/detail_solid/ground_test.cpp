#include "nodes/detail/detail_solid/ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "nodes/detail/detail_solid/quilt.h"
#include "runtime/random.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

// Stripes of 6 pixels, of which squares of `hole` pixels in every 64 are unknown.
PartialPicture stripes(int size, int hole) {
  PartialPicture p;
  p.width = p.height = size;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const bool known = x % 64 >= hole || y % 64 >= hole;
      p.known.push_back(known);
      p.value.push_back(Vec3f::Constant(known ? (y / 6 % 2 ? 0.7F : 0.3F) : 99));
    }
  return p;
}

TEST(Quilt, ContinuesTheTextureWithoutWhatIsUnknown) {
  const PartialPicture quilt = quilt_picture(stripes(192, 24), 150, 150, 1);
  ASSERT_GT(quilt.width, 120);
  ASSERT_GT(quilt.height, 120);
  int changes_across = 0;
  int wrong = 0;
  for (int y = 0; y < quilt.height; ++y)
    for (int x = 0; x < quilt.width; ++x) {
      const float v = quilt.value[pixel_at(x, y, quilt.width)].x();
      EXPECT_TRUE(v == 0.3F || v == 0.7F) << v;
      wrong += v != 0.3F && v != 0.7F;
      // The right edge continues at the left one.
      changes_across += v != quilt.value[pixel_at((x + 1) % quilt.width, y, quilt.width)].x();
    }
  ASSERT_EQ(wrong, 0);
  // Stripes run on: seams show in few pixels.
  EXPECT_LT(changes_across, 0.04 * quilt.width * quilt.height);
}

TEST(Quilt, DependsOnTheSeedAlone) {
  PartialPicture noise = stripes(128, 20);
  for (std::size_t i = 0; i < noise.value.size(); ++i)
    noise.value[i] = Vec3f::Constant(static_cast<float>(Random(3, 1, i).uniform()));
  const PartialPicture a = quilt_picture(noise, 100, 100, 1);
  EXPECT_EQ(a.value, quilt_picture(noise, 100, 100, 1).value);
  EXPECT_NE(a.value, quilt_picture(noise, 100, 100, 2).value);
}

TEST(Quilt, NeedsPlacesAsWideAsItsPieces) {
  PartialPicture p = stripes(128, 0);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x)
      if (x % 10 == 0) p.known[pixel_at(x, y, p.width)] = 0;  // 9 pixels are known between
  EXPECT_TRUE(quilt_picture(p, 100, 100, 1).value.empty());
}

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

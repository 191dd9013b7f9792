#include "nodes/detail/detail_solid/fill.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using namespace detail_solid;

// Checks of 8 × 8 pixels with a hole of `hole` pixels per side in the middle.
PartialPicture checks(int size, int hole) {
  PartialPicture p;
  p.width = p.height = size;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      p.value.push_back(Vec3f::Constant((x / 8 + y / 8) % 2 ? 0.2f : -0.2f));
      p.known.push_back(std::abs(x - size / 2) > hole / 2 || std::abs(y - size / 2) > hole / 2);
    }
  return p;
}

TEST(FillPicture, KeepsWhatIsKnownAndContinuesAPattern) {
  const PartialPicture wanted = checks(96, 22);
  PartialPicture p = wanted;
  for (std::size_t i = 0; i < p.value.size(); ++i)
    if (!p.known[i]) p.value[i] = Vec3f::Constant(9);  // must not be read
  fill_picture(p, 1);
  double wrong = 0, holes = 0;
  for (std::size_t i = 0; i < p.value.size(); ++i) {
    if (wanted.known[i]) {
      EXPECT_EQ(p.value[i], wanted.value[i]);
    } else {
      ++holes, wrong += (p.value[i] - wanted.value[i]).norm() > 0.1f;
    }
    EXPECT_LE(std::abs(p.value[i].x()), 0.2001f);
  }
  EXPECT_LT(wrong / holes, 0.1);
}

// At half the size, a hole of one pixel vanishes.
TEST(FillPicture, SmallHolesAreFilledToo) {
  const PartialPicture wanted = checks(96, 0);
  PartialPicture p = wanted;
  std::fill(p.known.begin(), p.known.end(), 1);
  p.known[50 * 96 + 50] = 0;
  p.value[50 * 96 + 50] = Vec3f::Constant(9);
  fill_picture(p, 1);
  for (std::size_t i = 0; i < p.value.size(); ++i) ASSERT_NEAR(p.value[i].x(), wanted.value[i].x(), 1e-5f);
}

TEST(FillPicture, CopiesFromAllPlaces) {
  PartialPicture p;
  p.width = p.height = 120;
  std::map<float, int> copies;
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const double grain = Random(5, 1, pixel_at(x, y, p.width)).uniform() - 0.5;
      p.known.push_back(y < 60);
      p.value.push_back(Vec3f::Constant(static_cast<float>((x + 20) * grain)));  // smoothest on the left
      if (p.known.back()) copies[p.value.back().x()] = 0;
    }
  fill_picture(p, 1);
  for (int y = 60; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) ++copies.at(p.value[pixel_at(x, y, p.width)].x());
  double copied = 0;
  for (const auto& [value, times] : copies) copied += times > 0;
  EXPECT_GT(copied / copies.size(), 0.35);
}

TEST(FillPicture, GrainKeepsItsDeviation) {
  PartialPicture p;
  p.width = p.height = 80;
  double known = 0, count = 0;
  for (int i = 0; i < 80 * 80; ++i) {
    p.value.push_back(
        Vec3f::Constant(static_cast<float>(Random(3, 0, static_cast<std::uint64_t>(i)).normal())));
    p.known.push_back(i % 80 < 40);
    if (p.known.back()) known += p.value.back().squaredNorm(), ++count;
  }
  const auto before = p.known;
  fill_picture(p, 1);
  double filled = 0, holes = 0;
  for (std::size_t i = 0; i < p.value.size(); ++i)
    if (!before[i]) filled += p.value[i].squaredNorm(), ++holes;
  EXPECT_GT(std::sqrt(filled / holes) / std::sqrt(known / count), 0.8);  // means of patches would have 0.2
  EXPECT_LT(std::sqrt(filled / holes) / std::sqrt(known / count), 1.2);
}

TEST(FillPicture, PiecesNarrowerThanAPatchSuffice) {
  PartialPicture p;
  p.width = p.height = 48;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 48; ++x) {
      p.value.push_back(Vec3f::Constant(0.3f));
      p.known.push_back(x % 8 < 3 && y % 8 < 3);
    }
  fill_picture(p, 1);
  for (const Vec3f& v : p.value) ASSERT_NEAR(v.x(), 0.3f, 0.3f + 1e-5f);
  double mean = 0;
  for (const Vec3f& v : p.value) mean += v.x() / static_cast<double>(p.value.size());
  EXPECT_GT(mean, 0.25);
}

}  // namespace
}  // namespace terrazzo

// Bodies of color that join particles, and those that do not.
#include <gtest/gtest.h>

#include "nodes/photograph/segment/color/joined_bodies.h"

namespace terrazzo::segment {
namespace {

constexpr int kSide = 40;

struct Scene {
  LabImage image{kSide, kSide, std::vector<Vec3f>(kSide* kSide)};
  std::vector<std::int32_t> labels = std::vector<std::int32_t>(kSide * kSide, 0);
  std::vector<Instance> instances;

  explicit Scene(const Vec3f& binder) { std::fill(image.pixels.begin(), image.pixels.end(), binder); }
  void body(const Vec3f& color) {  // 20 × 12 pixels
    each(10, 30, 10, 22, [&](std::size_t i) { labels[i] = 1, image.pixels[i] = color; });
  }
  void part(int left, int right, const Vec3f& color) {
    Instance one;
    one.score = 0.8;
    each(left, right, 11, 21,
         [&](std::size_t i) { one.pixels.push_back(static_cast<std::int32_t>(i)), image.pixels[i] = color; });
    instances.push_back(one);
  }
  bool joined() const { return joined_bodies(image, labels, 1, instances, {})[0]; }
  template <class Do>
  void each(int left, int right, int top, int bottom, const Do& act) {
    for (int y = top; y < bottom; ++y)
      for (int x = left; x < right; ++x) act(image.index(x, y));
  }
};

Vec3f gray(float lightness) { return {lightness, 0, 0}; }

TEST(JoinedBodies, HaveAGapTowardTheBindersColor) {
  // From 0.3, the binder at 0.6 is 0.3 away, so a gap begins at 0.4.
  for (const auto& [gap, expected] : {std::pair(0.45f, true), {0.41f, true}, {0.38f, false}, {0.3f, false}}) {
    Scene s(gray(0.6f));
    s.body(gray(gap));
    s.part(11, 18, gray(0.3f));
    s.part(22, 29, gray(0.3f));
    EXPECT_EQ(s.joined(), expected) << gap;
  }
}

TEST(JoinedBodies, HaveAtLeastTwoPartsSideBySide) {
  Scene s(gray(0.6f));
  s.body(gray(0.45f));
  s.part(11, 18, gray(0.3f));
  EXPECT_FALSE(s.joined());
  s.part(12, 18, gray(0.3f));  // a version of the first
  EXPECT_FALSE(s.joined());
  s.part(22, 29, gray(0.3f));
  EXPECT_TRUE(s.joined());
}

TEST(JoinedBodies, AreNotPoresWithSpecks) {
  // Specks lighter than the binder, as light as it is, and darker; the pore is black.
  for (const float speck : {0.9f, 0.61f, 0.4f}) {
    Scene s(gray(0.6f));
    s.body(gray(0.05f));
    s.part(11, 16, gray(speck));
    s.part(22, 27, gray(speck));
    EXPECT_FALSE(s.joined()) << speck;
  }
}

TEST(JoinedBodies, AreNotGrainsOfAnotherHue) {
  // The rest is between both in lightness, but of a color that neither has.
  Scene s(gray(0.6f));
  s.body({0.45f, 0.2f, 0});
  s.part(11, 18, gray(0.3f));
  s.part(22, 29, gray(0.3f));
  EXPECT_FALSE(s.joined());
}

TEST(JoinedBodies, HaveGapsNarrowerThanTheirParts) {
  // The parts have a radius of 2.5 pixels and are 4 or 11 pixels apart.
  for (const auto& [right, expected] : {std::pair(17, true), {24, false}}) {
    Scene s(gray(0.6f));
    s.part(11, 13, gray(0.3f));
    s.part(right, right + 2, gray(0.3f));
    s.each(11, right + 2, 11, 21, [&](std::size_t i) {
      s.labels[i] = 1;
      if (s.image.pixels[i][0] > 0.5f) s.image.pixels[i] = gray(0.45f);
    });
    EXPECT_EQ(s.joined(), expected) << right;
  }
}

TEST(JoinedBodies, AreNotFilledByTheirParts) {
  Scene s(gray(0.6f));
  s.body(gray(0.45f));
  s.labels.assign(s.labels.size(), 0);
  s.part(11, 18, gray(0.3f));
  s.part(18, 25, gray(0.3f));
  for (const Instance& one : s.instances)
    for (const auto i : one.pixels) s.labels[i] = 1;
  EXPECT_FALSE(s.joined());
}

}  // namespace
}  // namespace terrazzo::segment

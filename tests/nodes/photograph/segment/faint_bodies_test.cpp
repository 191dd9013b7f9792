// Bodies that color hardly tells from the binder.
#include <gtest/gtest.h>

#include "nodes/photograph/segment/color/faint_bodies.h"

namespace terrazzo::segment {
namespace {

// A mosaic with one row of patches of 10 × 10 pixels.
Mosaic row_of(const std::vector<Vec3f>& colors, float noise) {
  Mosaic m;
  m.width = static_cast<int>(10 * colors.size());
  m.height = 10;
  m.noise = noise;
  m.colors = colors;
  for (int y = 0; y < m.height; ++y)
    for (int x = 0; x < m.width; ++x) m.patches.push_back(x / 10 + 1);
  return m;
}

std::vector<std::int32_t> labels_of(const Mosaic& m, const std::vector<std::int32_t>& of_patch) {
  std::vector<std::int32_t> labels;
  for (const auto patch : m.patches) labels.push_back(of_patch[patch - 1]);
  return labels;
}

TEST(FaintBodies, AreWithinSixDeviationsOfTheBinder) {
  const Vec3f binder(0.5f, 0.01f, 0), up(1, 0, 0), hue(0, 0.6f, 0.8f);
  const float noise = 0.01f;
  const Mosaic m = row_of({binder, binder + 5.5f * noise * up, binder, binder + 6.5f * noise * up,
                           binder - 5.5f * noise * hue, binder - 6.5f * noise * hue, binder},
                          noise);
  EXPECT_EQ(faint_bodies(m, labels_of(m, {0, 1, 0, 2, 3, 4, 0}), 4), std::vector({true, false, true, false}));
}

TEST(FaintBodies, CountByTheMeanOfTheirPatches) {
  const Vec3f binder(0.5f, 0, 0), far(0.7f, 0, 0);
  const Mosaic m = row_of({binder, binder, far, binder, binder, binder, binder, binder}, 0.01f);
  // A third of the body: 6.7 deviations.
  EXPECT_FALSE(faint_bodies(m, labels_of(m, {0, 1, 1, 1, 0, 0, 0, 0}), 1)[0]);
  // A quarter: 5 deviations.
  EXPECT_TRUE(faint_bodies(m, labels_of(m, {1, 1, 1, 1, 0, 0, 0, 0}), 1)[0]);
}

TEST(FaintBodies, NoneWithoutABinderOrPixels) {
  const Mosaic m = row_of({Vec3f(0.5f, 0, 0), Vec3f(0.5f, 0, 0)}, 0.01f);
  EXPECT_EQ(faint_bodies(m, labels_of(m, {1, 2}), 2), std::vector({false, false}));
  EXPECT_EQ(faint_bodies(m, labels_of(m, {0, 2}), 2), std::vector({false, true}));
}

}  // namespace
}  // namespace terrazzo::segment

// Corrections by color: binder between touching particles, ragged outlines, particles of two materials.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/data/image.h"
#include "nodes/photograph/segment/color/mosaic.h"
#include "nodes/photograph/segment/color/two_materials.h"
#include "nodes/photograph/segment/outline/contacts.h"
#include "nodes/photograph/segment/outline/smooth_outlines.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using segment::open_contacts;
using segment::smooth_outlines;

constexpr int kSceneSize = 96;

struct LabeledScene {
  Image image;
  std::vector<std::int32_t> labels;
  std::vector<float> coverage;
  segment::LabImage colors() const { return segment::patch_section(image, 0, {}); }
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * kSceneSize + x; }
  std::ptrdiff_t pixels_of(std::int32_t id) const { return std::count(labels.begin(), labels.end(), id); }
  void cover() {
    coverage.clear();
    for (const auto l : labels) coverage.push_back(l > 0 ? 1.0f : 0.0f);
  }
  void expect_coverage_agrees() const {
    for (std::size_t i = 0; i < labels.size(); ++i) ASSERT_EQ(coverage[i] >= 0.5f, labels[i] != 0) << i;
  }
};

// Two bright stones of 30 × 40 pixels on dark binder. Between columns 47 − width / 2 and 47 + width / 2, the
// picture shows a joint, but the labels touch there.
LabeledScene two_stones(int width, const Vec3f& stone, const Vec3f& binder, float noise = 0.01f) {
  LabeledScene s;
  s.image = Image(kSceneSize, kSceneSize, 1, 1);
  s.labels.assign(s.image.pixels.size(), 0);
  Random random(3);
  const int from = 47 - width / 2, to = from + width;
  for (int y = 0; y < kSceneSize; ++y)
    for (int x = 0; x < kSceneSize; ++x) {
      const bool inside = y >= 28 && y < 68 && x >= 17 && x < 77;
      const bool joint = x >= from && x < to;
      const Vec3f c = inside && !joint ? stone : binder;
      for (int k = 0; k < 3; ++k)
        s.image.pixels[s.at(x, y)][k] = c[k] + noise * static_cast<float>(random.uniform() - 0.5);
      if (inside) s.labels[s.at(x, y)] = x < 47 ? 1 : 2;
    }
  s.cover();
  return s;
}

const Vec3f kBright(0.5f, 0.4f, 0.3f), kDark(0.03f, 0.03f, 0.02f);

TEST(OpenContacts, AJointBecomesBinder) {
  for (const int width : {1, 2, 4}) {
    LabeledScene s = two_stones(width, kBright, kDark);
    open_contacts(s.image, 0, s.colors(), s.labels, s.coverage, {});
    EXPECT_EQ(s.pixels_of(1) + s.pixels_of(2), (60 - width) * 40) << width;
    s.expect_coverage_agrees();
  }
}

TEST(OpenContacts, WhatCannotBeToldFromTheBinderStays) {
  LabeledScene close = two_stones(2, kBright, 0.97f * kBright, 0.05f);
  const LabeledScene before = close;
  open_contacts(close.image, 0, close.colors(), close.labels, close.coverage, {});
  EXPECT_EQ(close.labels, before.labels);
  EXPECT_EQ(close.coverage, before.coverage);
  // No binder at all.
  LabeledScene filled = two_stones(2, kBright, kDark);
  for (auto& l : filled.labels) l = std::max(l, 1);
  filled.cover();
  const auto all = filled.labels;
  open_contacts(filled.image, 0, filled.colors(), filled.labels, filled.coverage, {});
  EXPECT_EQ(filled.labels, all);
}

TEST(OpenContacts, SpecksAndThinParticlesStay) {
  LabeledScene s = two_stones(0, kBright, kDark);
  for (const int y : {40, 41}) s.image.pixels[s.at(45, y)] = kDark;  // a dark grain
  // A third particle lies in the joint, and is as dark as the binder.
  for (int y = 50; y < 60; ++y)
    for (int x = 46; x < 48; ++x) s.labels[s.at(x, y)] = 3, s.image.pixels[s.at(x, y)] = 1.2f * kDark;
  const auto before = s.labels;
  open_contacts(s.image, 0, s.colors(), s.labels, s.coverage, {});
  EXPECT_EQ(s.labels, before);
}

// A disc of radius 25 whose labeled outline is ragged by up to `ragged` pixels.
LabeledScene ragged_disc(double ragged, float texture) {
  LabeledScene s;
  s.image = Image(kSceneSize, kSceneSize, 1, 1);
  s.labels.assign(s.image.pixels.size(), 0);
  Random random(7);
  for (int y = 0; y < kSceneSize; ++y)
    for (int x = 0; x < kSceneSize; ++x) {
      const double r = std::hypot(x - 47.5, y - 47.5);
      const float grain = texture * static_cast<float>(random.uniform() - 0.5);
      s.image.pixels[s.at(x, y)] = ((r < 25 ? 1 : 0.3f) + grain) * Vec3f(0.4f, 0.4f, 0.4f);
      if (r + ragged * (random.uniform() - 0.5) < 25) s.labels[s.at(x, y)] = 1;
    }
  s.cover();
  return s;
}

double wrong_pixels(const LabeledScene& s) {
  double wrong = 0;
  for (int y = 0; y < kSceneSize; ++y)
    for (int x = 0; x < kSceneSize; ++x)
      wrong += (s.labels[s.at(x, y)] == 1) != (std::hypot(x - 47.5, y - 47.5) < 25);
  return wrong;
}

TEST(SmoothOutlines, RaggedOutlinesOfTexturedParticlesBecomeSmooth) {
  LabeledScene s = ragged_disc(4, 0.5f);
  const LabeledScene before = s;
  smooth_outlines(s.colors(), s.labels, s.coverage, {});
  EXPECT_LT(wrong_pixels(s), 0.5 * wrong_pixels(before));
  EXPECT_NEAR(static_cast<double>(s.pixels_of(1)), static_cast<double>(before.pixels_of(1)), 4);
  s.expect_coverage_agrees();
}

TEST(SmoothOutlines, CleanParticlesKeepTheirPixels) {
  LabeledScene s = ragged_disc(4, 0.01f);
  const LabeledScene before = s;
  smooth_outlines(s.colors(), s.labels, s.coverage, {});
  EXPECT_EQ(s.labels, before.labels);
  EXPECT_EQ(s.coverage, before.coverage);
}

TEST(SmoothOutlines, TouchingParticlesShareNoPixelAndKeepTheirAreas) {
  LabeledScene s = ragged_disc(4, 0.5f);
  for (int y = 0; y < kSceneSize; ++y)
    for (int x = 48; x < kSceneSize; ++x)
      if (s.labels[s.at(x, y)] == 1) s.labels[s.at(x, y)] = 2;
  const LabeledScene before = s;
  smooth_outlines(s.colors(), s.labels, s.coverage, {});
  for (const int id : {1, 2})
    EXPECT_NEAR(static_cast<double>(s.pixels_of(id)), static_cast<double>(before.pixels_of(id)),
                0.02 * static_cast<double>(before.pixels_of(id)));
  s.expect_coverage_agrees();
}

// A dark disc of radius 25 and a gray one of radius `attached` at its side, as one particle.
LabeledScene pore_and_grain(double attached, const Vec3f& gray) {
  LabeledScene s;
  s.image = Image(kSceneSize, kSceneSize, 1, 1);
  s.labels.assign(s.image.pixels.size(), 0);
  for (int y = 0; y < kSceneSize; ++y)
    for (int x = 0; x < kSceneSize; ++x) {
      const bool pore = std::hypot(x - 40, y - 48) < 25, grain = std::hypot(x - 67, y - 48) < attached;
      s.image.pixels[s.at(x, y)] = pore ? kDark : grain ? gray : Vec3f(0.6f, 0.6f, 0.6f);
      s.labels[s.at(x, y)] = pore || grain;
    }
  s.cover();
  return s;
}

TEST(TwoMaterials, AGrainAtAPoreBecomesAParticle) {
  LabeledScene s = pore_and_grain(10, Vec3f(0.25f, 0.25f, 0.25f));
  const std::ptrdiff_t all = s.pixels_of(1);
  EXPECT_EQ(segment::split_two_materials(s.colors(), s.labels, 7, {}), std::vector<std::int32_t>{1});
  EXPECT_EQ(s.pixels_of(1) + s.pixels_of(7), all);
  EXPECT_EQ(s.labels[s.at(40, 48)], 1);
  EXPECT_EQ(s.labels[s.at(72, 48)], 7);
  double wrong = 0;
  for (std::size_t i = 0; i < s.labels.size(); ++i)
    wrong += s.labels[i] > 0 && (s.labels[i] == 1) != (s.image.pixels[i] == kDark);
  EXPECT_LT(wrong, 30);
}

TEST(TwoMaterials, VeinsRimsSpecksAndShadingStay) {
  const auto splits = [](LabeledScene s) {
    return segment::split_two_materials(s.colors(), s.labels, 2, {}).size();
  };
  const Vec3f gray(0.25f, 0.25f, 0.25f);
  EXPECT_EQ(splits(pore_and_grain(10, gray)), 1u);
  EXPECT_EQ(splits(pore_and_grain(10, kDark)), 0u);  // one color
  EXPECT_EQ(splits(pore_and_grain(3, gray)), 0u);    // a speck at the rim
  LabeledScene vein = pore_and_grain(0, gray), rim = vein, shaded = vein;
  for (int y = 0; y < kSceneSize; ++y)
    for (int x = 0; x < kSceneSize; ++x) {
      const std::size_t i = vein.at(x, y);
      if (vein.labels[i] == 0) continue;
      if (std::abs(y - 48) < 4) vein.image.pixels[i] = gray;
      if (std::hypot(x - 40, y - 48) > 19) rim.image.pixels[i] = gray;
      shaded.image.pixels[i] = (0.1f + 0.01f * static_cast<float>(x)) * Vec3f(0.5f, 0.5f, 0.5f);
    }
  EXPECT_EQ(splits(vein), 0u);
  EXPECT_EQ(splits(rim), 0u);
  EXPECT_EQ(splits(shaded), 0u);
}

}  // namespace
}  // namespace terrazzo

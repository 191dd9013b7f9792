// Segment decides from the shading of particles whether a photograph shows a cut or a surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/photograph/segment/segment.h"
#include "nodes/photograph/synthetic_photo/synthetic_photo.h"
#include "runtime/random.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

// Sixteen discs on a ground. `dome`: how much darker their rims are than their middles; `slope`: how fast
// they grow lighter to the right, per radius; both relative. `blur`: width of the outline, pixels.
struct Discs {
  Image image{320, 320, 1, 0.5};
  Labels labels;
  Discs(double dome, double slope, double blur, float ground = 0.1F) {
    Random random(7);
    labels.width = labels.height = 320;
    labels.sections = 1;
    labels.pixel_size = 0.5;
    labels.ids.assign(image.pixels.size(), 0);
    labels.classes.assign(16, 0);
    constexpr double kRadius = 32;
    for (int y = 0; y < 320; ++y)
      for (int x = 0; x < 320; ++x) {
        const double u = (x % 80 - 39.5) / kRadius, v = (y % 80 - 39.5) / kRadius, r = std::hypot(u, v);
        if (r < 1) labels.ids[image.index(x, y)] = y / 80 * 4 + x / 80 + 1;
        const double height = std::sqrt(std::max(0.0, 1 - r * r));
        const double inside = std::clamp(0.5 + (1 - r) * kRadius / blur, 0.0, 1.0);
        const double stone = 0.4 * (1 - dome * (1 - height)) * (1 + slope * u);
        const double light = inside * stone + (1 - inside) * ground;
        image.at(x, y).setConstant(static_cast<float>(light * (1 + 0.02 * random.normal())));
      }
  }
};

Segmentation measured(const Discs& d, std::optional<View> view = {}) {
  SegmentOptions options;
  options.find_objects = false;
  options.view = view;
  return measure_labels(d.image, d.labels, options, {});
}

TEST(SegmentView, DomesAreASurfaceAndFlatDiscsASection) {
  const Segmentation domes = measured({0.5, 0.3, 2});
  EXPECT_EQ(domes.profiles.view, View::Surface);
  EXPECT_EQ(domes.evidence.judged, 16);
  EXPECT_GT(domes.evidence.shaded, 0.9);
  // The light comes from the right.
  EXPECT_NEAR(domes.profiles.light.x(), 0.3, 0.06);
  EXPECT_NEAR(domes.profiles.light.y(), 0, 0.03);
  for (const Profile& p : domes.profiles.profiles) EXPECT_NEAR(p.whole / p.area, 1, 0.02);

  const Segmentation flat = measured({0, 0, 2});
  EXPECT_EQ(flat.profiles.view, View::Section);
  EXPECT_LT(flat.evidence.shaded, 0.1);
  EXPECT_EQ(flat.profiles.light, Vec2::Zero());
  for (const Profile& p : flat.profiles.profiles) EXPECT_EQ(p.whole, 0);
}

TEST(SegmentView, ABlurredRimIsNoShading) {
  EXPECT_EQ(measured({0, 0, 5}).profiles.view, View::Section);
  EXPECT_EQ(measured({0, 0, 5, 0.9F}).profiles.view, View::Section);
}

TEST(SegmentView, DiscsThatAreLighterAtTheRimAreNoStones) {
  EXPECT_EQ(measured({-0.5, 0.3, 2}).profiles.view, View::Section);
}

TEST(SegmentView, TheParameterDecides) {
  EXPECT_EQ(measured({0.5, 0.3, 2}, View::Section).profiles.view, View::Section);
  EXPECT_EQ(measured({0, 0, 2}, View::Surface).profiles.view, View::Surface);
  EXPECT_EQ(measured({0, 0, 2}, View::Filling).profiles.view, View::Filling);
}

TEST(SegmentView, CoveredPicturesAreFillings) {
  EXPECT_EQ(judged_view({.judged = 30, .shaded = 0.1}, 0.98), View::Filling);
  EXPECT_EQ(judged_view({.judged = 30, .shaded = 0.1}, 0.9), View::Section);
  EXPECT_EQ(judged_view({.judged = 30, .shaded = 0.6}, 0.98), View::Surface);
  EXPECT_EQ(judged_view({.judged = 4, .shaded = 1}, 0.5), View::Section);  // too few to tell
}

TEST(SegmentView, HalvesThatDifferAreTold) {
  ViewEvidence e;
  e.halves = {{{30, 25}, {40, 2}, {35, 14}, {35, 13}}};
  const auto mixed = mixed_view(e);
  ASSERT_TRUE(mixed);
  EXPECT_STREQ(mixed->surface, "left");
  EXPECT_STREQ(mixed->cut, "right");
  EXPECT_EQ(mixed->of_surface.shaded, 25);
  e.halves = {{{35, 14}, {35, 13}, {40, 2}, {30, 25}}};
  ASSERT_TRUE(mixed_view(e));
  EXPECT_STREQ(mixed_view(e)->surface, "lower");

  EXPECT_FALSE(mixed_view({}));
  e.halves = {{{19, 19}, {40, 0}, {20, 9}, {39, 10}}};  // too few on the left
  EXPECT_FALSE(mixed_view(e));
  e.halves = {{{100, 95}, {100, 45}, {100, 70}, {100, 70}}};  // both are surfaces
  EXPECT_FALSE(mixed_view(e));
  e.halves = {{{40, 13}, {40, 10}, {40, 11}, {40, 12}}};  // by chance
  EXPECT_FALSE(mixed_view(e));
}

// Domes at the left, flat discs at the right.
TEST(SegmentView, AHalfCutPhotographIsTold) {
  Image image(320, 320, 1, 0.5);
  Labels labels;
  labels.width = labels.height = 320;
  labels.sections = 1;
  labels.pixel_size = 0.5;
  labels.ids.assign(image.pixels.size(), 0);
  labels.classes.assign(64, 0);
  Random random(5);
  for (int y = 0; y < 320; ++y)
    for (int x = 0; x < 320; ++x) {
      const double r = std::hypot(x % 40 - 19.5, y % 40 - 19.5) / 17;
      if (r < 1) labels.ids[image.index(x, y)] = y / 40 * 8 + x / 40 + 1;
      const double height = std::sqrt(std::max(0.0, 1 - r * r));
      const double light = r >= 1 ? 0.1 : x < 160 ? 0.2 + 0.2 * height : 0.4;
      image.at(x, y).setConstant(static_cast<float>(light * (1 + 0.02 * random.normal())));
    }
  const auto warned = [&](const char* view) {
    const auto run = test::run_node("Segment", {{"image", Value::of(image)}, {"labels", Value::of(labels)}},
                                    {{"view", view}, {"find_objects", "false"}});
    return std::count_if(run.warnings.begin(), run.warnings.end(), [](const std::string& w) {
      return w.find("part cut and part surface: in its left half") != std::string::npos &&
             w.find("taken as a surface") != std::string::npos;
    });
  };
  EXPECT_EQ(warned("auto"), 1);
  EXPECT_EQ(warned("surface"), 0);
}

// Drawn scenes with their own labels: of 16 of each kind, at most two are mistaken.
TEST(SegmentView, DrawnScenesAreTold) {
  using synthetic_photo::Scene;
  for (const Scene scene : {Scene::Bank, Scene::Heap, Scene::Section}) {
    const auto photo = synthetic_photo::take_photo(
        {.scene = scene, .pictures = 16, .width = 256, .height = 256, .objects = false, .seed = 4711}, {});
    int surfaces = 0;
    const std::size_t size = 256 * 256;
    for (int k = 0; k < 16; ++k) {
      Image one(256, 256, 1, 1);
      Labels labels;
      labels.width = labels.height = 256;
      labels.sections = 1;
      labels.ids.assign(photo.labels.ids.begin() + k * size, photo.labels.ids.begin() + (k + 1) * size);
      std::copy_n(photo.image.pixels.begin() + k * size, size, one.pixels.begin());
      surfaces += judged_view(view_evidence(one, labels, {}), 0.5) == View::Surface;
    }
    if (scene == Scene::Section)
      EXPECT_LE(surfaces, 2);
    else
      EXPECT_GE(surfaces, 14) << static_cast<int>(scene);
  }
}

}  // namespace
}  // namespace terrazzo

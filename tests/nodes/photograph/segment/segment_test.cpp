#include "nodes/photograph/segment/segment.h"

#include <gtest/gtest.h>

#include <limits>

#include "graph/diagnostic.h"
#include "nodes/common/io/image_file.h"
#include "nodes/data/table.h"
#include "tests/nodes/photograph/segment/synthetic_section.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

using test::code_of;

using test::Disc;

const Profile* at(const Profiles& profiles, const Disc& d, int height) {
  const Profile* best = nullptr;
  for (const auto& p : profiles.profiles)
    if ((p.centroid - Vec2(d.x, height - d.y)).norm() < 1.5) best = &p;
  return best;
}

TEST(Segment, FindsEveryDiscWithItsAreaWithinOnePercent) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto discs = test::scatter(256, 256, 24, 9, 24, seed);
    const Segmentation s = segment::segment(test::picture(256, 256, discs), {}, {});
    EXPECT_EQ(s.profiles.profiles.size(), discs.size());
    double sum = 0, truth = 0;
    for (std::size_t i = 0; i < discs.size(); ++i) {
      const Profile* p = at(s.profiles, discs[i], 256);
      ASSERT_NE(p, nullptr) << "disc " << i << " of seed " << seed;
      const double area = std::numbers::pi * discs[i].radius * discs[i].radius;
      EXPECT_NEAR(p->area, area, 0.02 * area);
      EXPECT_LT((p->centroid - Vec2(discs[i].x, 256 - discs[i].y)).norm(), 0.1);
      EXPECT_LT((p->color - test::chip_color(i)).norm(), 0.01);
      for (const auto& q : p->contour)
        EXPECT_NEAR((q - Vec2(discs[i].x, 256 - discs[i].y)).norm(), discs[i].radius, 0.35);
      sum += p->area;
      truth += area;
    }
    EXPECT_NEAR(sum, truth, 0.01 * truth);
    EXPECT_NEAR(s.profiles.area_fraction, truth / (256 * 256), 0.01 * truth / (256 * 256));
    EXPECT_LT((s.profiles.binder_color - test::binder_light).norm(), 0.02);
  }
}

TEST(Segment, NoiseIsNoParticle) {
  const auto discs = test::scatter(256, 256, 24, 9, 24, 4);
  for (const double noise : {0.03, 0.15}) {
    const Segmentation s = segment::segment(test::picture(256, 256, discs, noise), {}, {});
    EXPECT_EQ(s.profiles.profiles.size(), discs.size()) << noise;
    for (const auto& d : discs) {
      const Profile* p = at(s.profiles, d, 256);
      ASSERT_NE(p, nullptr);
      EXPECT_NEAR(p->area / (std::numbers::pi * d.radius * d.radius), 1, 0.08);
    }
  }
}

TEST(Segment, DarkBinderAndUnevenLight) {
  const auto discs = test::scatter(256, 256, 20, 10, 22, 6);
  Image image(256, 256, 1, 1, Vec3f(0.05f, 0.06f, 0.07f));
  for (const auto& d : discs) test::draw(image, d, {0.3f, 0.28f, 0.25f});
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) image.at(x, y) *= 1 + 1.2f * static_cast<float>(x) / 256;
  const Segmentation s = segment::segment(image, {}, {});
  EXPECT_EQ(s.profiles.profiles.size(), discs.size());
  for (const auto& d : discs) EXPECT_NE(at(s.profiles, d, 256), nullptr);
}

TEST(Segment, TouchingDiscsArePartedAtTheirNeck) {
  Image image(160, 160, 1, 1, test::binder_light);
  const Disc a{50, 80, 24}, b{92, 80, 20}, other{120, 130, 15};
  for (const auto& d : {a, b, other}) test::draw(image, d, {0.1f, 0.08f, 0.05f});
  SegmentOptions whole;
  whole.split.strength = 0;
  whole.method = segment::Method::Clusters;  // the network has no such parameter
  EXPECT_EQ(segment::segment(image, whole, {}).profiles.profiles.size(), 2u);
  const Segmentation s = segment::segment(image, {}, {});
  ASSERT_EQ(s.profiles.profiles.size(), 3u);
  EXPECT_NE(at(s.profiles, other, 160), nullptr);
  double sum = 0;
  for (const auto& p : s.profiles.profiles) sum += p.area;
  // The lens-shaped overlap of both disks counts once.
  const double lens = [&] {
    const double d = 42, r = 24, q = 20;
    const double u = (d * d + r * r - q * q) / (2 * d), v = d - u;
    return r * r * std::acos(u / r) - u * std::sqrt(r * r - u * u) + q * q * std::acos(v / q) -
           v * std::sqrt(q * q - v * v);
  }();
  const double truth = std::numbers::pi * (24 * 24 + 20 * 20 + 15 * 15) - lens;
  EXPECT_NEAR(sum, truth, 0.01 * truth);
}

TEST(Segment, TouchingDiscsOfTwoColorsAreParted) {
  Image image(160, 160, 1, 1, test::binder_light);
  test::draw(image, {60, 80, 30}, {0.25f, 0.1f, 0.05f});
  test::draw(image, {95, 80, 14}, {0.01f, 0.01f, 0.012f});  // deep in the first one: no neck separates them
  test::draw(image, {130, 130, 14}, {0.01f, 0.01f, 0.012f});
  const Segmentation s = segment::segment(image, {}, {});
  ASSERT_EQ(s.profiles.profiles.size(), 3u);
  EXPECT_NE(at(s.profiles, {95, 80, 14}, 160), nullptr);
}

TEST(Segment, HolesAreFilledAndSpecksDroppedAndCounted) {
  Image image(200, 200, 1, 1, test::binder_light);
  const Disc big{70, 70, 40};
  test::draw(image, big, {0.1f, 0.05f, 0.04f});
  test::draw(image, {70, 70, 10}, test::binder_light);
  test::draw(image, {150, 150, 25}, {0.1f, 0.05f, 0.04f});
  for (int i = 0; i < 5; ++i) test::draw(image, {120.5 + 12 * i, 30.5, 2}, {0.1f, 0.05f, 0.04f});
  SegmentOptions options;
  options.method = Method::Clusters;
  options.split.min_area = 20;
  const Segmentation s = segment::segment(image, options, {});
  ASSERT_EQ(s.profiles.profiles.size(), 2u);
  EXPECT_EQ(s.specks, 5);
  const Profile* p = at(s.profiles, big, 200);
  ASSERT_NE(p, nullptr);
  EXPECT_NEAR(p->area, std::numbers::pi * 1600, 0.01 * std::numbers::pi * 1600);
}

TEST(Segment, BinderHintChoosesTheSide) {
  // Stripes of equal light and dark area: neither side is more convex.
  Image image(128, 128, 1, 1, Vec3f::Constant(0.6f));
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x)
      if (y / 16 % 2) image.at(x, y) = Vec3f::Constant(0.05f);
  SegmentOptions options;
  options.binder.kind = Hint::Kind::Darkest;
  EXPECT_GT(segment::segment(image, options, {}).profiles.profiles[0].color[0], 0.5f);
  options.binder.kind = Hint::Kind::Lightest;
  EXPECT_LT(segment::segment(image, options, {}).profiles.profiles[0].color[0], 0.1f);
  options.binder.kind = Hint::Kind::Color;
  options.binder.color = patch_color_of_linear(Vec3f::Constant(0.55f));
  EXPECT_LT(segment::segment(image, options, {}).profiles.profiles[0].color[0], 0.1f);
}

TEST(Segment, ColorClasses) {
  const auto discs = test::scatter(256, 256, 24, 9, 20, 9);
  const Image image = test::picture(256, 256, discs);
  SegmentOptions options;
  options.color_classes = 4;
  const Segmentation s = segment::segment(image, options, {});
  EXPECT_EQ(s.profiles.classes, 4);
  for (const int k : {0, 1, 2, 3}) {
    int cls = -1;
    for (std::size_t i = k; i < discs.size(); i += 4) {
      const Profile* p = at(s.profiles, discs[i], 256);
      ASSERT_NE(p, nullptr);
      if (cls < 0) cls = p->cls;
      EXPECT_EQ(p->cls, cls);
    }
  }
  EXPECT_EQ(segment::segment(image, {}, {}).profiles.classes, 1);
}

TEST(Segment, LabelsInputIsMeasured) {
  const Disc d{40.3, 30.8, 17};
  Image image(80, 64, 1, 0.5, test::binder_light);
  test::draw(image, d, {0.1f, 0.2f, 0.3f});
  Labels labels;
  labels.width = 80;
  labels.height = 64;
  labels.pixel_size = 1;
  labels.ids.assign(80 * 64, 0);
  labels.classes = {0, 2};  // id 1 has no pixel
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 80; ++x)
      if (std::hypot(x + 0.5 - d.x, y + 0.5 - d.y) < d.radius) labels.ids[labels.index(x, y)] = 2;
  const auto run = test::run_node("Segment", {{"image", Value::of(image)}, {"labels", Value::of(labels)}});
  const auto& profiles = run.output<Profiles>("profiles");
  ASSERT_EQ(profiles.profiles.size(), 1u);
  const Profile& p = profiles.profiles[0];
  EXPECT_EQ(p.cls, 2);
  EXPECT_EQ(profiles.classes, 3);
  EXPECT_NEAR(p.area, 0.25 * std::numbers::pi * 17 * 17, 0.25 * 0.015 * std::numbers::pi * 17 * 17);
  EXPECT_LT((p.centroid - 0.5 * Vec2(d.x, 64 - d.y)).norm(), 0.1);
  EXPECT_LT((p.color - Vec3f(0.1f, 0.2f, 0.3f)).norm(), 0.01);
  EXPECT_EQ(run.output<Labels>("labels").count(), 1);
  EXPECT_DOUBLE_EQ(profiles.observed_area, 80 * 64 * 0.25);
  EXPECT_EQ(run.output<Table>("binder").rows.size(), 1u);
  labels.width = 64;
  labels.height = 80;
  EXPECT_EQ(code_of([&] { measure_labels(image, labels, {}, {}); }), "size-mismatch");
}

TEST(Segment, StackOfSections) {
  Image stack(128, 128, 2, 1, test::binder_light);
  const Disc a{40, 40, 20}, b{80, 70, 25}, c{30, 95, 15};
  test::draw(stack, a, {0.1f, 0.05f, 0.04f}, 0);
  test::draw(stack, b, {0.1f, 0.05f, 0.04f}, 1);
  test::draw(stack, c, {0.1f, 0.05f, 0.04f}, 1);
  const Segmentation s = segment::segment(stack, {}, {});
  ASSERT_EQ(s.profiles.profiles.size(), 3u);
  EXPECT_EQ(s.profiles.profiles[0].section, 0);
  EXPECT_EQ(s.profiles.profiles[2].section, 1);
  EXPECT_DOUBLE_EQ(s.profiles.observed_area, 2.0 * 128 * 128);
  EXPECT_EQ(s.labels.ids[s.labels.index(40, 40, 0)], 1);
  EXPECT_GE(s.labels.ids[s.labels.index(80, 70, 1)], 2);
}

TEST(Segment, SameBitsForAnyNumberOfThreads) {
  const auto discs = test::scatter(300, 300, 40, 5, 22, 12);
  const Value image = Value::of(test::picture(300, 300, discs, 0.05));
  const auto one = test::run_node("Segment", {{"image", image}}, {{"color_classes", "auto"}}, {}, 1);
  const auto two = test::run_node("Segment", {{"image", image}}, {{"color_classes", "auto"}}, {}, 2);
  for (const char* port : {"labels", "profiles", "binder"}) {
    BufferWriter a, b;
    one.outputs.at(port).type().encode(one.outputs.at(port).data(), a);
    two.outputs.at(port).type().encode(two.outputs.at(port).data(), b);
    EXPECT_EQ(a.buffer, b.buffer) << port;
  }
}

TEST(Segment, BadInput) {
  EXPECT_EQ(code_of([] { segment::segment(Image(), {}, {}); }), "empty-image");
  EXPECT_EQ(code_of([] { segment::segment(Image(64, 64, 1, 1, Vec3f::Constant(0.4f)), {}, {}); }),
            "one-color");
  EXPECT_EQ(code_of([] { segment::segment(Image(1, 1, 1, 1, Vec3f::Constant(0.4f)), {}, {}); }), "one-color");
  Image nan = test::picture(64, 64, {{30, 30, 12}});
  nan.at(3, 4)[2] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(code_of([&] { segment::segment(nan, {}, {}); }), "bad-pixels");
  SegmentOptions large;
  large.split.min_area = 1e6;
  EXPECT_EQ(code_of([&] {
              segment::segment(test::picture(64, 64, {{30, 30, 12}}), large, {});
            }),
            "no-particles");
  for (const auto& [w, h] :
       {std::pair{1, 50}, {50, 1}, {2, 2}, {3, 3}, {7, 5}}) {  // an error or a result, never a crash
    Image tiny(w, h, 1, 1, Vec3f::Constant(0.6f));
    tiny.at(w / 2, h / 2) = Vec3f::Constant(0.1f);
    const std::string code = code_of([&] { segment::segment(tiny, {}, {}); });
    EXPECT_TRUE(code == "" || code == "no-particles" || code == "one-color")
        << w << " × " << h << ": " << code;
  }
  Labels none;
  none.width = none.height = 64;
  none.ids.assign(64 * 64, 0);
  EXPECT_EQ(code_of([&] { measure_labels(Image(64, 64, 1, 1), none, {}, {}); }), "no-particles");
}

TEST(Segment, CancelsWhenAsked) {
  const std::atomic<bool> cancel{true};
  const Work::Report report;
  EXPECT_THROW(segment::segment(test::picture(128, 128, {{60, 60, 20}}), {}, Work(&cancel, &report)),
               Cancelled);
}

// Real photographs with known properties. The bounds are wide: they detect failures, not small changes.
TEST(Segment, RealPictures) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const Segmentation cermet = segment::segment(read_image(data / "photos/cermet.png"), {}, {});
  EXPECT_NEAR(cermet.profiles.area_fraction, 0.33, 0.033);
  EXPECT_NEAR(static_cast<double>(cermet.profiles.profiles.size()), 62, 10);
  const Segmentation alloy = segment::segment(read_image(data / "photos/superalloy/spot5_0d_0.png"), {}, {});
  EXPECT_NEAR(alloy.profiles.area_fraction, 0.497, 0.06);
}

}  // namespace
}  // namespace terrazzo

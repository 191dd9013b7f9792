// Particles by example.
#include <gtest/gtest.h>

#include "nodes/data/profiles.h"
#include "nodes/photograph/instance_score/instance_score.h"
#include "nodes/photograph/segment/scribbles/scribbles.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace segment;

// Discs that differ from the binder in texture alone: both are black and white noise of the same mean, fine
// in the binder and coarse in the discs. No method that looks at color can find them.
struct Textured {
  Image image{160, 120, 1, 1};
  Labels truth;
};
Textured textured_discs() {
  Textured t;
  t.truth.width = 160;
  t.truth.height = 120;
  t.truth.ids.assign(160 * 120, 0);
  t.truth.classes.assign(12, 0);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const int cx = x / 40 * 40 + 20, cy = y / 40 * 40 + 20;
      const bool disc = (x - cx) * (x - cx) + (y - cy) * (y - cy) < 14 * 14;
      const int grain = disc ? 5 : 1;
      Random r(3, static_cast<std::uint64_t>(x / grain),
               static_cast<std::uint64_t>(y / grain) + (disc ? 1000 : 0));
      t.image.at(x, y).setConstant(r.uniform() < 0.5 ? 0.2f : 0.6f);
      if (disc) t.truth.ids[t.truth.index(x, y)] = x / 40 + 4 * (y / 40) + 1;
    }
  return t;
}
Strokes line(double x0, double y0, double x1, double y1, double radius) {
  return {{Stroke{{{Vec2(x0, y0), Vec2(x1, y1)}}, radius, false}}};
}
Strokes on_three_discs() {
  Strokes s;
  for (const double x : {20.0, 60.0, 100.0})
    s.strokes.push_back({{{Vec2(x - 8, 20), Vec2(x + 8, 20)}}, 6, false});
  return s;
}

TEST(Scribbles, AFewStrokesTeachATexture) {
  const Textured t = textured_discs();
  const Value on_disc = Value::of(on_three_discs()), on_binder = Value::of(line(40, 4, 40, 116, 3));
  const auto run = test::run_node(
      "Segment",
      {{"image", Value::of(t.image)}, {"particle_strokes", on_disc}, {"binder_strokes", on_binder}},
      {{"min_area", "100"}});
  EXPECT_EQ(run.metrics.at("by_scribbles"), 1);
  const auto score = instance_score::compare_instances(run.output<Labels>("labels"), t.truth);
  EXPECT_GE(score.average_precision(0.5), 0.8)
      << score.found << " found, " << score.matched(0.5) << " matched, area " << score.found_area << " of "
      << score.mask_area;
  for (const Profile& p : run.output<Profiles>("profiles").profiles)
    EXPECT_TRUE(p.confidence > 0 && p.confidence <= 1);
}

TEST(Scribbles, TheSameBitsOnAnyNumberOfThreads) {
  const Textured t = textured_discs();
  const Value on_disc = Value::of(on_three_discs()), on_binder = Value::of(line(40, 4, 40, 116, 3));
  std::vector<std::vector<std::int32_t>> all;
  for (const int threads : {1, 2, 7})
    all.push_back(
        test::run_node(
            "Segment",
            {{"image", Value::of(t.image)}, {"particle_strokes", on_disc}, {"binder_strokes", on_binder}}, {},
            {}, threads)
            .output<Labels>("labels")
            .ids);
  EXPECT_EQ(all[1], all[0]);
  EXPECT_EQ(all[2], all[0]);
}

TEST(Scribbles, WhatIsNotMaterialIsNotObserved) {
  Textured t = textured_discs();
  for (int y = 100; y < 120; ++y)
    for (int x = 0; x < 160; ++x) t.image.at(x, y) = Vec3f(0.8f, 0.1f, 0.1f);
  const std::multimap<std::string, Value> inputs{
      {"image", Value::of(t.image)},
      {"particle_strokes", Value::of(on_three_discs())},
      {"binder_strokes", Value::of(line(40, 4, 40, 90, 3))},
      {"not_material_strokes", Value::of(line(10, 110, 150, 110, 4))}};
  const auto run = test::run_node("Segment", inputs);
  EXPECT_NEAR(run.output<Profiles>("profiles").observed_area, 160 * 100, 160 * 4);
}

TEST(Scribbles, BothClassesAreNeeded) {
  const Textured t = textured_discs();
  const Value stroke = Value::of(line(12, 20, 28, 20, 6)), outside = Value::of(line(-50, -50, -40, -40, 2));
  for (const auto& [particles, binder] : {std::pair{stroke, outside}, {outside, stroke}})
    EXPECT_EQ(test::code_of([&, p = particles, b = binder] {
                test::run_node(
                    "Segment",
                    {{"image", Value::of(t.image)}, {"particle_strokes", p}, {"binder_strokes", b}});
              }),
              "no-strokes");
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Segment", {{"image", Value::of(t.image)}}, {{"method", "scribbles"}});
            }),
            "no-strokes");
}

}  // namespace
}  // namespace terrazzo

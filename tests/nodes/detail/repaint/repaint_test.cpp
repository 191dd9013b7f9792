#include "nodes/detail/repaint/repaint.h"

#include <gtest/gtest.h>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using repaint::repaint;

// Disks of two colors with stripes in them, in a gray binder.
test::DrawnPicture striped_disks() {
  return test::draw_disks(160, 40, 14, [](int x, int, int id) {
    const float stripe = x % 3 == 0 ? 0.1f : 0;  // a third of the pixels, so that the median is the color
    return Vec3f((id == 0  ? Vec3f(0.5f, 0.5f, 0.5f)
                  : id % 2 ? Vec3f(0.8f, 0.3f, 0.2f)
                           : Vec3f(0.1f, 0.2f, 0.4f))
                     .array() +
                 stripe);
  });
}

// A tile for the binder and one for all profiles, each of one value.
Detail even_detail(float binder, float profiles) {
  Detail d;
  d.pixel_size = 0.1;
  d.size = 4;
  d.phases.resize(2);
  d.phases[1].color = Vec3f::Constant(0.4f);
  d.phases[0].tile.assign(64, Vec3f::Constant(binder));
  d.phases[1].tile.assign(64, Vec3f::Constant(profiles));
  return d;
}

TEST(Repaint, WithoutDetailEveryProfileHasItsMedianColor) {
  const auto drawn = striped_disks();
  const Image out = repaint(drawn.image, drawn.labels, nullptr, 1);
  ASSERT_EQ(out.pixels.size(), drawn.image.pixels.size());
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    const std::int32_t id = drawn.labels.ids[i];
    if (id > 0) {
      ASSERT_LT((linear_to_srgb(out.pixels[i]) - (id % 2 ? Vec3f(0.8f, 0.3f, 0.2f) : Vec3f(0.1f, 0.2f, 0.4f)))
                    .norm(),
                1e-4f)
          << i;
    } else {
      ASSERT_NEAR(
          out.pixels[i].x(),
          (2 * srgb_to_linear(Vec3f::Constant(0.5f)).x() + srgb_to_linear(Vec3f::Constant(0.6f)).x()) / 3,
          0.004f);
    }
  }
}

TEST(Repaint, DetailIsAddedByPhase) {
  const auto drawn = striped_disks();
  const Image flat = repaint(drawn.image, drawn.labels, nullptr, 1);
  const Detail detail = even_detail(0.02f, -0.05f);
  const Image out = repaint(drawn.image, drawn.labels, &detail, 1);
  const auto away_from_outlines = [&](int x, int y) {
    for (int v = std::max(0, y - 2); v <= std::min(159, y + 2); ++v)
      for (int u = std::max(0, x - 2); u <= std::min(159, x + 2); ++u)
        if (drawn.labels.ids[v * 160 + u] != drawn.labels.ids[y * 160 + x]) return false;
    return true;
  };
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    if (!away_from_outlines(static_cast<int>(i % 160), static_cast<int>(i / 160))) continue;
    const Vec3f before = linear_to_srgb(flat.pixels[i]), after = linear_to_srgb(out.pixels[i]);
    const float offset = drawn.labels.ids[i] > 0 ? -0.05f * Detail::particle_scale(before) : 0.02f;
    ASSERT_NEAR((after - before).mean(), offset, 1e-3f) << i;
  }
}

TEST(Repaint, ThreadsDoNotMatterAndSeedsDo) {
  const auto drawn = striped_disks();
  Detail detail = even_detail(0, 0);
  for (std::size_t i = 0; i < 64; ++i)
    detail.phases[0].tile[i] = Vec3f::Constant(0.01f * static_cast<float>(i % 7));
  const auto run = [&](int threads, const char* seed) {
    return test::run_node("Repaint",
                          {{"image", Value::of(drawn.image)},
                           {"labels", Value::of(drawn.labels)},
                           {"detail", Value::of(detail)}},
                          {{"seed", seed}}, {}, threads)
        .output<Image>("image");
  };
  const Image one = run(1, "1");
  EXPECT_EQ(one.pixels, run(7, "1").pixels);
  EXPECT_NE(one.pixels, run(1, "2").pixels);
}

TEST(Repaint, RejectsWhatDoesNotFit) {
  const auto drawn = striped_disks();
  EXPECT_EQ(test::code_of([&] { repaint(Image(), drawn.labels, nullptr, 1); }), "empty-image");
  EXPECT_EQ(test::code_of([&] { repaint(Image(8, 8, 1, 0.1), drawn.labels, nullptr, 1); }), "size-mismatch");
  Labels odd = drawn.labels;
  odd.ids[5] = odd.count() + 1;
  EXPECT_EQ(test::code_of([&] { repaint(drawn.image, odd, nullptr, 1); }), "bad-labels");
}

TEST(Repaint, APictureWithoutParticlesIsBinder) {
  const auto drawn = striped_disks();
  Labels none = drawn.labels;
  std::fill(none.ids.begin(), none.ids.end(), 0);
  none.classes.clear();
  const Detail detail = even_detail(0.02f, 0);
  const Image out = repaint(drawn.image, none, &detail, 1);
  EXPECT_NEAR(
      (linear_to_srgb(out.at(3, 3)) - linear_to_srgb(repaint(drawn.image, none, nullptr, 1).at(3, 3))).mean(),
      0.02f, 1e-4f);
}

}  // namespace
}  // namespace terrazzo

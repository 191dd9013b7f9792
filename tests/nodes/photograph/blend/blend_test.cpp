#include "nodes/photograph/blend/blend.h"

#include <gtest/gtest.h>

#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace blend;

Image plain(const Vec3f& color, int sections = 1) { return Image(3, 2, sections, 1.0, color); }

Vec3f one(const Vec3f& below, const Vec3f& over, Mode mode, double amount = 1) {
  return blend_images(plain(below), plain(over), {}, mode, amount, {}).pixels[4];
}

TEST(Blend, FollowsTheFormulas) {
  const Vec3f b(0.2f, 0.5f, 0.9f), o(0.5f, 0.6f, 0.4f);
  EXPECT_TRUE(one(b, o, Mode::Mix).isApprox(o));
  EXPECT_TRUE(one(b, o, Mode::Multiply).isApprox(Vec3f(0.1f, 0.3f, 0.36f)));
  EXPECT_TRUE(one(b, o, Mode::Screen).isApprox(Vec3f(0.6f, 0.8f, 0.94f)));
  EXPECT_TRUE(one(b, o, Mode::Overlay).isApprox(Vec3f(0.2f, 0.6f, 0.88f)));
  EXPECT_TRUE(one(b, o, Mode::Add).isApprox(Vec3f(0.7f, 1.1f, 1.3f)));
  EXPECT_TRUE(one(b, o, Mode::Subtract).isApprox(Vec3f(0, 0, 0.5f)));
  EXPECT_TRUE(one(b, o, Mode::Difference).isApprox(Vec3f(0.3f, 0.1f, 0.5f)));
  EXPECT_TRUE(one(b, o, Mode::Mix, 0.25).isApprox(0.75f * b + 0.25f * o));
  EXPECT_EQ(one(b, o, Mode::Add, 0), b);
}

TEST(Blend, ShowsTheUpperPictureWhereTheMaskIs) {
  const Vec3f b(0.2f, 0.2f, 0.2f), o(0.8f, 0.4f, 0.6f);
  Image mask = plain(Vec3f::Zero());
  mask.at(1, 0) = Vec3f::Constant(0.5f);
  mask.at(2, 1) = Vec3f::Constant(7);
  const Image out = blend_images(plain(b), plain(o), {&mask, nullptr}, Mode::Mix, 1, {});
  EXPECT_EQ(out.at(0, 0), b);
  EXPECT_TRUE(out.at(1, 0).isApprox(0.5f * (b + o)));
  EXPECT_TRUE(out.at(2, 1).isApprox(o));

  const Labels labels{3, 2, 1, 1.0, {0, 0, 1, 2, 0, 0}, {0, 0}};
  const auto run = test::run_node(
      "Blend", {{"image", Value::of(plain(b))}, {"over", Value::of(plain(o))}, {"mask", Value::of(labels)}});
  for (int i = 0; i < 6; ++i)
    EXPECT_TRUE(run.output<Image>("image").pixels[i].isApprox(i == 2 || i == 3 ? o : b));
}

// One section above is above every one below.
TEST(Blend, RepeatsASingleSection) {
  Image below = plain(Vec3f::Ones(), 2), over = plain(Vec3f::Ones());
  over.at(1, 1) = Vec3f(0.5f, 0, 0);
  const Image out = blend_images(below, over, {}, Mode::Multiply, 1, {});
  EXPECT_EQ(out.at(1, 1, 1), over.at(1, 1));
  EXPECT_EQ(out.at(0, 1, 1), Vec3f(Vec3f::Ones()));
}

TEST(Blend, RefusesOtherSizes) {
  const auto code = [](const Image& below, const Image& over) {
    return test::code_of([&] { blend_images(below, over, {}, Mode::Mix, 1, {}); });
  };
  EXPECT_EQ(code(plain(Vec3f::Ones()), Image(2, 3, 1, 1.0)), "size-mismatch");
  EXPECT_EQ(code(plain(Vec3f::Ones(), 3), plain(Vec3f::Ones(), 2)), "size-mismatch");
  EXPECT_EQ(code(Image{}, plain(Vec3f::Ones())), "empty-image");
}

}  // namespace
}  // namespace terrazzo

// What only photographs of surfaces leave in values survives the cache.
#include <gtest/gtest.h>

#include <cmath>

#include "nodes/data/detail.h"
#include "nodes/data/shapes.h"
#include "runtime/codec.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

template <class T>
auto encoded(const T& value) {
  BufferWriter w;
  value_type<T>().encode(&value, w);
  return w.buffer;
}

template <class T, class Bytes>
std::shared_ptr<const T> decoded(const Bytes& bytes) {
  Reader r(bytes.data(), bytes.size());
  return std::static_pointer_cast<const T>(value_type<T>().decode(r));
}

TEST(SurfaceTypes, TracedShapesAreStored) {
  Shapes shapes = test::one_shape(test::sphere_mesh(1));
  const auto plain = encoded(shapes);
  shapes.shapes[0].traced = {7, Vec2(1.5, -2), 0.25, true};
  const auto back = decoded<Shapes>(encoded(shapes));
  EXPECT_EQ(back->shapes[0].traced.profile, 7);
  EXPECT_EQ(back->shapes[0].traced.origin, Vec2(1.5, -2));
  EXPECT_EQ(back->shapes[0].traced.turn, 0.25);
  EXPECT_TRUE(back->shapes[0].traced.faceted);
  EXPECT_EQ(decoded<Shapes>(plain)->shapes[0].traced.profile, 0);
  shapes.shapes[0].color.assign(shapes.shapes[0].mesh.vertices.size(), Vec3f(1, 0, 0));
  EXPECT_EQ(decoded<Shapes>(encoded(shapes))->shapes[0].color, shapes.shapes[0].color);
  EXPECT_EQ(decoded<Shapes>(encoded(shapes))->shapes[0].traced.profile, 7);
}

TEST(SurfaceTypes, SkinsGroundAndTonesAreStored) {
  Detail detail;
  Detail::Skin skin;
  skin.profile = 3;
  skin.corner = {1, 2};
  skin.size = 4;
  skin.color = Vec3f(0.1F, 0.2F, 0.3F);
  skin.width = 2;
  skin.height = 1;
  skin.center = {1, 0.5F};
  skin.shade = {Vec3f(1, 2, 3), Vec3f(4, 5, 6)};
  detail.skins.push_back(skin);
  detail.ground.width = 1;
  detail.ground.height = 2;
  detail.ground.shade = {Vec3f(7, 8, 9), Vec3f(1, 1, 1)};
  detail.tones = {0, 0.5F, 1};
  detail.relief = {Eigen::Vector2f(0.6F, 0.8F), 2};
  const auto back = decoded<Detail>(encoded(detail));
  ASSERT_EQ(back->skins.size(), 1U);
  EXPECT_EQ(back->skins[0].profile, 3);
  EXPECT_EQ(back->skins[0].corner, skin.corner);
  EXPECT_EQ(back->skins[0].color, skin.color);
  EXPECT_EQ(back->skins[0].center, skin.center);
  EXPECT_EQ(back->skins[0].spread, skin.spread);
  EXPECT_EQ(back->skins[0].shade, skin.shade);
  EXPECT_EQ(back->relief.light, detail.relief.light);
  EXPECT_EQ(back->relief.strength, 2);
  EXPECT_EQ(back->ground.shade, detail.ground.shade);
  EXPECT_EQ(back->tones, detail.tones);
  detail.skins[0].shade[1].y() = std::nanf("");
  EXPECT_EQ(test::code_of([&] { decoded<Detail>(encoded(detail)); }), "damaged");
  detail.skins[0].shade[1].y() = 5;
  detail.skins[0].width = 3;
  EXPECT_EQ(test::code_of([&] { decoded<Detail>(encoded(detail)); }), "damaged");
  detail.skins.clear();
  detail.ground.height = 3;
  EXPECT_EQ(test::code_of([&] { decoded<Detail>(encoded(detail)); }), "damaged");
}

}  // namespace
}  // namespace terrazzo

// Pictures of solids for browsers without WebGL.
#include "runtime/clients/studio/views/solid_picture.h"

#include <gtest/gtest.h>

#include "nodes/data/opaque_volume.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "tests/nodes/bodies/section/packing.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using studio::solid_picture;

// How many pixels are clearly redder than green.
int red_pixels(const Image& image) {
  int out = 0;
  for (const Vec3f& c : image.pixels) out += c[0] > 2 * c[1];
  return out;
}

TEST(StudioSolidPicture, ShowsParticlesWithTheirShapesFromAllSides) {
  Shapes shapes;
  shapes.shapes = {test::cube()};
  Particles p;
  p.box = Vec3::Constant(3);
  p.resize(2);
  p.position = {Vec3(0.8, 1.5, 1.5), Vec3(2.2, 1.5, 1.5)};  // side by side along x
  p.color = {Vec3f(0.8f, 0.05f, 0.05f), Vec3f(0.05f, 0.8f, 0.05f)};
  const Value solid = Value::of(p), with = Value::of(shapes);
  const Image side = solid_picture(solid, with, -90), end = solid_picture(solid, with, 0);
  EXPECT_EQ(side.width, 640);
  EXPECT_EQ(side.height, 480);
  // From +x the red particle is behind the green one.
  EXPECT_GT(red_pixels(side), 5000);
  EXPECT_LT(red_pixels(end), red_pixels(side) / 2);
  EXPECT_EQ(test::code_of([&] { solid_picture(solid, {}, 0); }), "bad-request");
  p.shape[1] = 3;
  EXPECT_EQ(test::code_of([&] { solid_picture(Value::of(p), with, 0); }), "no-such-shape");
}

TEST(StudioSolidPicture, ShowsShapesSideBySide) {
  Shapes shapes;
  shapes.shapes = {test::cube()};
  const Image one = solid_picture(Value::of(shapes), {}, -41);
  shapes.shapes.assign(5, test::cube());
  EXPECT_NE(solid_picture(Value::of(shapes), {}, -41).pixels, one.pixels);
  EXPECT_EQ(test::code_of([] { solid_picture(Value::of(Shapes{}), {}, 0); }), "no-particles");
}

TEST(StudioSolidPicture, RefusesWhatHasNoPicture) {
  EXPECT_EQ(test::code_of([] { solid_picture(Value::of(Image(2, 2, 1, 1)), {}, 0); }), "bad-request");
  EXPECT_EQ(test::code_of([] { solid_picture(Value::of(Volume{}), {}, 0); }), "no-color");
}

}  // namespace
}  // namespace terrazzo

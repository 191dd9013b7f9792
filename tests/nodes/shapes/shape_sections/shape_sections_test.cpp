#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/image.h"
#include "nodes/data/profiles.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/shapes/shape_sections/sections.h"
#include "tests/support/code_of.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape;

using std::numbers::pi;

TEST(ShapeSections, PrincipalOnesOfAnEllipsoid) {
  Mesh mesh = ellipsoid_mesh({6, 4, 2}, 4);
  transform(mesh, Quat(0.8, 0.3, -0.4, 0.2).normalized().toRotationMatrix(), {5, 6, 7});
  const auto run = test::run_node("ShapeSections", {{"shapes", Value::of(test::one_shape(mesh))}},
                                  {{"planes", "principal"}});
  const auto& p = run.output<Profiles>("profiles").profiles;
  ASSERT_EQ(p.size(), 3u);
  // The section across the longest axis is first.
  EXPECT_NEAR(p[0].area, pi * 2 * 1, 0.02 * pi * 2);
  EXPECT_NEAR(p[1].area, pi * 3 * 1, 0.02 * pi * 3);
  EXPECT_NEAR(p[2].area, pi * 3 * 2, 0.02 * pi * 6);
}

TEST(ShapeSections, ThePictureShowsTheProfiles) {
  const auto run =
      test::run_node("ShapeSections", {{"shapes", Value::of(test::one_shape(box_mesh({1, 2, 3})))}},
                     {{"count", "20"}, {"cell", "64"}});
  const auto& p = run.output<Profiles>("profiles");
  const auto& image = run.output<Image>("image");
  EXPECT_EQ(image.width, 5 * 64);
  EXPECT_EQ(image.height, 4 * 64);
  double black = 0, area = 0;
  for (const auto& v : image.pixels) black += (1 - v.x()) * image.pixel_size * image.pixel_size;
  for (const auto& q : p.profiles) {
    area += q.area;
    EXPECT_FALSE(q.touches_border);
    EXPECT_EQ(q.weight, 1);
    for (const auto& v : q.contour) {
      EXPECT_GE(v.minCoeff(), 0);
      EXPECT_LE(v.x(), p.window.x());
      EXPECT_LE(v.y(), p.window.y());
    }
  }
  EXPECT_NEAR(black, area, 0.002 * area);
  EXPECT_NEAR(p.area_fraction * p.observed_area, area, 1e-9 * area);
}

TEST(ShapeSections, IsTheSameOnAnyNumberOfThreads) {
  const Value body = Value::of(test::one_shape(box_mesh({1, 2, 3})));
  const auto a = test::run_node("ShapeSections", {{"shapes", body}}, {{"count", "300"}}, {}, 1);
  const auto b = test::run_node("ShapeSections", {{"shapes", body}}, {{"count", "300"}}, {}, 7);
  EXPECT_EQ(a.output<Image>("image").pixels, b.output<Image>("image").pixels);
}

TEST(ShapeSections, BadInputIsNamed) {
  EXPECT_EQ(test::code_of([] {
              test::run_node("ShapeSections", {{"shapes", Value::of(Shapes{})}});
            }),
            "no-shapes");
}

}  // namespace
}  // namespace terrazzo

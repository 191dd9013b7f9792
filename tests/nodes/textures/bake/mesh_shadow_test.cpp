#include "nodes/textures/bake/mesh_shadow.h"

#include <gtest/gtest.h>

#include "tests/nodes/textures/bake/bake_cases.h"

namespace terrazzo {
namespace {
using namespace bake_cases;
using bake::UvTexels;

struct Shadowed {
  UvTexels texels;
  std::vector<float> open;
};
Shadowed shadowed(const Shape& s, int size, double scale = 1) {
  Shadowed out;
  out.texels = bake::find_texels(s.mesh, s.uv, size, 0);
  const bake::TexelPlaces places(s.mesh, s.uv, size, scale);
  out.open = bake::open_sky(s.mesh, out.texels, places, scale);
  return out;
}

// A floor 2 mm wide in the left half of the texture, and at its right edge a wall 1 mm high in the other
// half. Both are so long that their ends do not matter in the middle.
Shape corner() {
  constexpr double kLong = 400;
  Shape s = rectangle({-2, -kLong}, {0, kLong}, 0, 0, 0, 0.5f, 1);
  s.mesh.vertices.insert(s.mesh.vertices.end(),
                         {{0, -kLong, 0}, {0, kLong, 0}, {0, kLong, 1}, {0, -kLong, 1}});
  s.mesh.triangles.insert(s.mesh.triangles.end(), {{4, 6, 5}, {4, 7, 6}});
  const Eigen::Vector2f a(0.55f, 1), b(0.55f, 0), c(1, 0), d(1, 1);
  s.uv.insert(s.uv.end(), {{a, c, b}, {a, d, c}});
  return s;
}

TEST(MeshShadow, WallBesideAFloorInClosedForm) {
  for (const int size : {64, 200, 1100}) {  // of the last, one texel in nine has rays
    const Shadowed s = shadowed(corner(), size, 3);
    const int row = size / 2;
    for (int x = 0; x < size / 2; ++x) {
      const double d = 2 - 2 * (x + 0.5) / (0.5 * size);  // mm to the wall
      const double open = 0.5 * (1 + d / std::sqrt(d * d + 1));
      ASSERT_NEAR(s.open[pixel_at(x, row, size)], open, 0.02) << size << ": " << x;
    }
  }
}

TEST(MeshShadow, ConvexMeshesAreOpenAndCavitiesDark) {
  Shape box;
  box.mesh = test::cube_mesh(3);
  for (std::size_t t = 0; t < box.mesh.triangles.size(); ++t) {  // a triangle of its own for each
    const float x = 0.25f * static_cast<float>(t % 4), y = 0.25f * static_cast<float>(t / 4);
    box.uv.push_back({Eigen::Vector2f(x + 0.02f, y + 0.02f), Eigen::Vector2f(x + 0.2f, y + 0.02f),
                      Eigen::Vector2f(x + 0.02f, y + 0.2f)});
  }
  for (const float open : shadowed(box, 128).open) ASSERT_EQ(open, 1);
  for (Triangle& t : box.mesh.triangles) std::swap(t[1], t[2]);
  for (const float open : shadowed(box, 128).open) ASSERT_LE(open, 0.01f);
}

TEST(MeshShadow, IsPartOfTheOcclusion) {
  const auto inputs = inputs_of(corner(), balls_on_a_lattice());
  const auto with = test::run_node("Bake", inputs, {{"resolution", "64"}});
  const auto without = test::run_node("Bake", inputs, {{"resolution", "64"}, {"shadow", "false"}});
  EXPECT_LT(with.output<Image>("occlusion").at(31, 32).x(), 0.6f);
  EXPECT_EQ(without.output<Image>("occlusion").at(31, 32).x(), 1);
  EXPECT_EQ(with.output<Image>("base_color").pixels, without.output<Image>("base_color").pixels);
}

}  // namespace
}  // namespace terrazzo

#include "nodes/bodies/view/soil.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "nodes/bodies/view/bed.h"
#include "tests/nodes/bodies/section/packing.h"
#include "tests/nodes/volumes/voxelize/bodies.h"

namespace terrazzo {
namespace {
using namespace view;

using Stones = std::vector<carving::RayScene::Instance>;

constexpr float kCell = 0.05f;

Shapes unit_ball() {
  Mesh mesh = test::sphere_mesh(4);
  for (Vec3& v : mesh.vertices) v *= 2;  // radius 1 mm
  return test::one_shape(std::move(mesh));
}

const StoneMeshes& balls() {
  static const StoneMeshes meshes(unit_ball());
  return meshes;
}

carving::RayScene::Instance ball_at(const Vec3f& center, float radius) {
  carving::RayScene::Instance stone;
  stone.linear *= radius;
  stone.offset = center;
  return stone;
}

TEST(Soil, FindsTheExposureThatAShareNeeds) {
  // Of 100 mm², the first covers 4π mm² of the ground, the second 2.25π, the third nothing, being below, and
  // the fourth nothing of the picture.
  const Stones stones = {ball_at({3, 3, 1}, 2), ball_at({7, 7, 3}, 1.5f), ball_at({5, 5, -6}, 1),
                         ball_at({15, 5, 0}, 1.1f)};
  std::vector<float> exposures;
  for (const auto& stone : stones)
    exposures.push_back(stone.offset.z() / reach_below(balls().triangles[0], stone.linear));
  EXPECT_NEAR(exposures[2], -6, 0.01);
  const auto needed = [&](double share) {
    return exposure_of_share(balls().triangles, stones, exposures, {Vec2(10, 10), kCell}, share);
  };
  const double first = 4 * std::numbers::pi / 100;
  EXPECT_NEAR(needed(0.9 * first), 0.5, 0.01);
  EXPECT_NEAR(needed(1.2 * first), 2, 0.01);
  EXPECT_NEAR(needed(0.9), 2, 0.01);  // all together cover less
}

// Soil neither moves nor keeps stones that lie higher than the photograph's share needs.
TEST(Soil, HoldsStonesWhereThePackingHasThem) {
  Particles p = test::one_particle(Vec3::Constant(10), Vec3(5, 5, 8.5), 1);
  p.resize(2);
  p.position[1] = Vec3(2, 2, 9.9);
  p.scale[1] = 1;
  const BedSoil soil{kCell, 0.02};
  const Bed bed(p, balls(), {9, Vec2::Zero()}, Vec2(10, 10), 4, &soil);
  BedPoint point;
  ASSERT_TRUE(bed.below(5, 5, point));
  EXPECT_NEAR(point.at.z(), 0.5, 0.01);
  EXPECT_NEAR((bed.in_packing(point) - Vec3f(5, 5, 9.5)).norm(), 0, 0.01f);
  EXPECT_FALSE(bed.below(2, 2, point) && point.at.z() > 0);
}

}  // namespace
}  // namespace terrazzo

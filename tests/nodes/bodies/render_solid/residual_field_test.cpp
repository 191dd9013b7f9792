// A photograph's fine detail on particles and binder.
#include "nodes/detail/residual/residual_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/carving/solid.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/image.h"
#include "nodes/data/volume.h"
#include "runtime/random.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace carving;
using residual::ResidualField;

Volume noise_volume(int n, double voxel, float strength = 0.1f) {
  initialize_openvdb();
  Volume v;
  v.resolution = Vec3i(n, n, n);
  auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  grid->setName("residual");
  grid->setTransform(voxel_transform(voxel));
  auto a = grid->getAccessor();
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        Random r(3, 3, static_cast<std::uint64_t>((z * n + y) * n + x));
        a.setValue({x, y, z}, openvdb::Vec3s(float(strength * r.normal()), float(strength * r.normal()),
                                             float(strength * r.normal())));
      }
  v.grids.push_back(grid);
  return v;
}

Vec3f voxel_of(const Volume& v, int x, int y, int z) {
  const auto grid = v.find<openvdb::Vec3SGrid>("residual");
  const int n = v.resolution.x();
  const auto c = grid->getConstAccessor().getValue({(x % n + n) % n, (y % n + n) % n, (z % n + n) % n});
  return {c[0], c[1], c[2]};
}

TEST(ResidualField, PassesThroughTheVoxelsAndTiles) {
  const Volume v = noise_volume(8, 0.5);
  const ResidualField field(v, Vec3(4, 4, 4));
  EXPECT_EQ(field.periods(), Vec3i(1, 1, 1));
  for (int z = -3; z < 12; ++z)
    for (int y = -2; y < 9; ++y)
      for (int x = -9; x < 9; ++x) {
        const Vec3f at = 0.5f * (Vec3f(float(x), float(y), float(z)).array() + 0.5f);
        ASSERT_LT((field.at(at, 0) - voxel_of(v, x, y, z)).norm(), 5e-4f);
        ASSERT_LT((field.at(at, -1) - voxel_of(v, x, y, z)).norm(), 5e-4f);
      }
}

TEST(ResidualField, FillsTheBoxWithWholePeriods) {
  const ResidualField field(noise_volume(8, 0.5), Vec3(9, 3, 22));
  EXPECT_EQ(field.periods(), Vec3i(2, 1, 6));  // 22 mm are 5.5 periods: 5 scale by 1.1, 6 by 0.917
  EXPECT_NEAR(field.scale().x(), 9.0 / 8, 1e-12);
  for (std::uint64_t k = 0; k < 300; ++k) {
    Random r(2, 2, k);
    const Vec3f at(float(r.uniform(0, 9)), float(r.uniform(0, 3)), float(r.uniform(0, 22)));
    for (const int particle : {-1, 0, 7})
      for (const Vec3f& period : {Vec3f(9, 0, 0), Vec3f(0, -3, 0), Vec3f(-9, 3, 22)})
        EXPECT_LT((field.at(at, particle) - field.at(at + period, particle)).norm(), 5e-3f);
  }
}

// If the tile fits into the box several times, the repetition must not show, neither from one particle to the
// next nor along the binder, whose grain is equally strong everywhere.
TEST(ResidualField, HidesThatTheTileRepeats) {
  const Volume v = noise_volume(16, 0.25);
  const ResidualField field(v, Vec3(40, 40, 40));
  ASSERT_EQ(field.periods(), Vec3i(10, 10, 10));
  double same = 0, square = 0, plain = 0, between = 0, in_particle = 0;
  constexpr int n = 20000;
  for (std::uint64_t k = 0; k < n; ++k) {
    Random r(4, 4, k);
    const Vec3f at(float(r.uniform(0, 40)), float(r.uniform(0, 40)), float(r.uniform(0, 40)));
    const Vec3f a = field.at(at, -1), b = field.at(at + Vec3f(4 * float(1 + k % 5), 0, 0), -1);
    same += a.dot(b);
    square += a.squaredNorm();
    const Vec3f p = field.at(at, 5);
    plain += p.squaredNorm();
    between += p.dot(field.at(at, 6));
    in_particle += p.dot(field.at(at + Vec3f(4, 0, 0), 5));
  }
  EXPECT_NEAR(in_particle / plain, 1, 0.01);  // it does repeat there, so the test would detect it
  EXPECT_LT(same / square, 0.35);
  EXPECT_LT(std::abs(between / plain), 0.05);
  EXPECT_NEAR(square / plain, 1, 0.06);
}

TEST(ResidualField, EveryBodyTakesIt) {
  Shapes shapes;
  shapes.shapes = {measure_shape("cube", test::cube_mesh())};
  Particles p;
  p.box = Vec3(4, 4, 4);
  p.resize(1);
  p.position[0] = Vec3(2, 2, 2);
  p.scale[0] = 2;
  p.color[0] = Vec3f(0.3f, 0.2f, 0.1f);
  p.binder_color = Vec3f(0.6f, 0.6f, 0.5f);
  const Volume v = noise_volume(8, 0.5, 0.05f);
  const ResidualField field(v, p.box);
  const auto wanted = [&](const Vec3f& flat, const Vec3f& mm, int particle) {
    return srgb_to_linear((linear_to_srgb(flat) + field.at(mm, particle)).cwiseMax(0.0f).cwiseMin(1.0f));
  };
  const auto paint = particle_paint(p, shapes, 1, {}, &field);
  const auto heap = particle_solid(p, shapes, &field);
  const auto broken = fracture_solid(*paint, p, shapes, 0.6, 0, 1, &field);
  SurfacePoint s;
  for (std::uint64_t k = 0; k < 200; ++k) {
    Random r(5, 5, k);
    const Vec3f mm(float(r.uniform(0, 4)), float(r.uniform(0, 4)), float(r.uniform(0, 4)));
    if (((mm.array() - 2).abs() - 1).abs().minCoeff() < 1e-3) continue;
    const bool in = (mm.array() - 2).abs().maxCoeff() < 1;
    EXPECT_LT(
        (paint->at(mm / 4, Vec3f::Zero(), true) - wanted(in ? p.color[0] : p.binder_color, mm, in ? 0 : -1))
            .norm(),
        1e-3f);
    EXPECT_EQ(paint->at(mm / 4, Vec3f::Zero(), false), in ? p.color[0] : p.binder_color);
    // From above onto the cube, whose top is at 3 mm; as a single particle it stands on the floor.
    const Vec3f top(std::clamp(mm.x(), 1.01f, 2.99f), std::clamp(mm.y(), 1.01f, 2.99f), 3);
    for (const auto* solid : {&heap, &broken}) {
      ASSERT_TRUE((*solid)->nearest(Vec3f(top.x() / 4, top.y() / 4, 3), Vec3f(0, 0, -1), s, true));
      EXPECT_LT((s.albedo - wanted(p.color[0], top, 0)).norm(), 2e-3f);
    }
  }
}

TEST(ResidualField, BadInput) {
  Shapes shapes;
  shapes.shapes = {measure_shape("cube", test::cube_mesh())};
  Particles p;
  p.box = Vec3(4, 4, 4);
  p.resize(1);
  p.position[0] = Vec3(2, 2, 2);
  const auto failure = [&](const Volume& residual) -> std::string {
    for (const std::string mode : {"vase", "fracture", "particles"}) try {
        test::run_node(
            "RenderSolid",
            {{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}, {"detail", Value::of(residual)}},
            {{"mode", mode}, {"width", "8"}, {"height", "8"}, {"samples", "1"}});
      } catch (const Error& e) {
        return e.diagnostic().code;
      }
    return "";
  };
  EXPECT_EQ(failure(noise_volume(4, 1)), "");
  EXPECT_EQ(failure(Volume()), "no-residual");
  Volume open = noise_volume(4, 1);
  open.resolution.setZero();
  EXPECT_EQ(failure(open), "bad-residual");
  Volume nan = noise_volume(4, 1);
  auto grid = nan.find<openvdb::Vec3SGrid>("residual")->deepCopy();
  grid->getAccessor().setValue({1, 1, 1}, openvdb::Vec3s(NAN, 0, 0));
  nan.grids = {grid};
  EXPECT_EQ(failure(nan), "bad-residual");
  // A scale far from the residual's own, and an unused residual, cause warnings.
  const auto warned = [&](const std::multimap<std::string, Value>& in) {
    return test::run_node("RenderSolid", in,
                          {{"width", "8"}, {"height", "8"}, {"samples", "1"}, {"mode", "cube"}})
        .warnings.size();
  };
  const Value residual = Value::of(noise_volume(4, 3)), particles = Value::of(p), forms = Value::of(shapes);
  EXPECT_EQ(warned({{"particles", particles}, {"shapes", forms}, {"detail", residual}}), 1u);
  Volume colors = noise_volume(4, 1);
  auto cd = colors.find<openvdb::Vec3SGrid>("residual")->deepCopy();
  cd->setName("Cd"),
      cd->denseFill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(3)), openvdb::Vec3s(0.5));
  colors.grids = {cd};
  EXPECT_EQ(warned({{"volume", Value::of(colors)}, {"detail", residual}}), 1u);
}

}  // namespace
}  // namespace terrazzo

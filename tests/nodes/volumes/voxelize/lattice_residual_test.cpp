#include "nodes/volumes/voxelize/lattice_residual.h"

#include <gtest/gtest.h>

#include <numbers>

#include "nodes/common/texture/color.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/voxelize/voxelize.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace voxelize;

// White noise with mean 0 and variance 1 on n³ voxels of `voxel` mm.
Volume noise(int n, double voxel) {
  initialize_openvdb();
  auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0f));
  grid->setName("residual");
  grid->setTransform(voxel_transform(voxel));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        Random r(1, 0, (static_cast<std::uint64_t>(i) * n + j) * n + k);
        grid->tree().setValueOn(
            {i, j, k}, openvdb::Vec3s(static_cast<float>(r.normal()), static_cast<float>(r.normal()), 0));
      }
  Volume v;
  v.resolution = Vec3i::Constant(n);
  v.grids = {grid};
  return v;
}

std::vector<Vec3f> sampled(const LatticeResidual& d, const Lattice& l) {
  const std::size_t plane = static_cast<std::size_t>(l.size.x()) * l.size.y();
  std::vector<Vec3f> out(plane * l.size.z(), Vec3f::Zero());
  for (int k = 0; k < l.size.z(); ++k) d.add_plane(k, &out[k * plane]);
  return out;
}

double variance(const std::vector<Vec3f>& v) {
  double s = 0, q = 0;
  for (const auto& x : v) {
    s += x.x();
    q += static_cast<double>(x.x()) * x.x();
  }
  const double n = static_cast<double>(v.size());
  return q / n - s / n * s / n;
}

TEST(LatticeResidual, VoxelsOnVoxelsAreCopied) {
  const Volume v = noise(16, 0.1);
  const Lattice l{Vec3i(32, 16, 48), 0.1};
  const LatticeResidual d(v, l, {});
  EXPECT_EQ(d.periods(), Vec3i(2, 1, 3));
  EXPECT_NEAR((d.scale() - Vec3::Ones()).norm(), 0, 1e-12);
  const auto out = sampled(d, l);
  const auto grid = v.find<openvdb::Vec3SGrid>("residual");
  for (int k = 0; k < 48; ++k)
    for (int j = 0; j < 16; ++j)
      for (int i = 0; i < 32; ++i)
        ASSERT_NEAR(out[(static_cast<std::size_t>(k) * 16 + j) * 32 + i].y(),
                    grid->tree().getValue({i % 16, j, k % 16})[1], 1e-6);
}

TEST(LatticeResidual, AWholeNumberOfPeriodsAtTheNearestScale) {
  const Volume v = noise(16, 0.1);  // period 1.6
  for (const auto& [edge, periods] : {std::pair{1.7, 1}, {2.2, 1}, {2.3, 2}, {2.5, 2}, {0.3, 1}, {8.1, 5}}) {
    const Lattice l{Vec3i::Constant(20), edge / 20};
    EXPECT_EQ(LatticeResidual(v, l, {}).periods().x(), periods) << edge;
  }
}

TEST(LatticeResidual, GrainKeepsItsVarianceAtOtherScales) {
  const Volume v = noise(24, 0.1);
  for (const int n : {25, 26, 31}) {
    const Lattice l{Vec3i::Constant(n), 2.4 / n};
    const auto out = sampled(LatticeResidual(v, l, {}), l);
    EXPECT_NEAR(variance(out), 1, 0.2) << n;  // trilinear: at most 0.3
    double mean = 0;
    for (const auto& x : out) mean += x.y() / static_cast<double>(out.size());
    EXPECT_NEAR(mean, 0, 0.03);
  }
  // Coarser voxels average white noise: its variance scales with the ratio of voxel volumes.
  const Lattice coarse{Vec3i::Constant(8), 0.3};
  EXPECT_NEAR(variance(sampled(LatticeResidual(v, coarse, {}), coarse)), 1.0 / 27, 0.02);
}

TEST(LatticeResidual, TilesInTheBox) {
  // A slow wave: the step across the face of the box is no larger than the steps inside.
  initialize_openvdb();
  auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0f));
  grid->setName("residual");
  grid->setTransform(voxel_transform(0.1));
  for (int i = 0; i < 16; ++i)
    for (int j = 0; j < 16; ++j)
      for (int k = 0; k < 16; ++k)
        grid->tree().setValueOn(
            {i, j, k}, openvdb::Vec3s(static_cast<float>(std::sin(2 * std::numbers::pi * i / 16)), 0, 0));
  Volume v;
  v.resolution = Vec3i::Constant(16);
  v.grids = {grid};
  const Lattice l{Vec3i::Constant(37), 0.1};  // 3.7 mm: two periods
  const auto out = sampled(LatticeResidual(v, l, {}), l);
  double inside = 0;
  for (int i = 0; i < 36; ++i) inside = std::max<double>(inside, std::abs(out[i + 1].x() - out[i].x()));
  EXPECT_LT(std::abs(out[36].x() - out[0].x()), inside * 1.05);
  EXPECT_GT(inside, 0.1);
}

TEST(LatticeResidual, IsAddedEverywhereAndMakesColorsDense) {
  const Particles p = test::one_particle(Vec3::Constant(1.6), Vec3::Constant(0.8), 0.8);
  const Volume v = noise(16, 0.1);
  const Shapes shapes = test::shapes_of(test::cube_mesh());
  VoxelReport report;
  const Lattice l = choose_lattice(p.box, {16});
  const Volume plain = voxelize::voxelize(p, shapes, nullptr, l, report),
               grained = voxelize::voxelize(p, shapes, &v, l, report);
  const auto a = plain.find<openvdb::Vec3SGrid>("Cd"), b = grained.find<openvdb::Vec3SGrid>("Cd"),
             r = v.find<openvdb::Vec3SGrid>("residual");
  EXPECT_EQ(b->activeVoxelCount(), 4096u);
  EXPECT_LT(a->activeVoxelCount(), 4096u);
  for (auto it = b->cbeginValueOn(); it; ++it) {
    const auto mean = a->tree().getValue(it.getCoord()), offset = r->tree().getValue(it.getCoord());
    const Vec3f shown = linear_to_srgb({mean[0], mean[1], mean[2]}) + Vec3f(offset[0], offset[1], offset[2]);
    const Vec3f expected = srgb_to_linear(shown.cwiseMax(0.0f));
    for (int c = 0; c < 3; ++c) ASSERT_NEAR((*it)[c], expected[c], 1e-4 * std::max(1.0f, expected[c]));
  }
}

TEST(LatticeResidual, ParticlesAPeriodApartAreNotAlikeInside) {
  // Two equal cubes half a box apart, with a residual that repeats after half a box.
  Particles p = test::one_particle(Vec3::Constant(3.2), Vec3::Constant(0.8), 1.0);
  const Particles one = p;
  p.resize(2);
  p.shape[1] = one.shape[0];
  p.orientation[1] = one.orientation[0];
  p.scale[1] = one.scale[0];
  p.size[1] = one.size[0];
  p.color[1] = one.color[0];
  p.position[1] = one.position[0] + Vec3(1.6, 0, 0);
  const Volume v = noise(16, 0.1);
  VoxelReport report;
  const Volume made =
      voxelize::voxelize(p, test::shapes_of(test::cube_mesh()), &v, choose_lattice(p.box, {32}), report);
  ASSERT_EQ(report.detail_periods, Vec3i::Constant(2));
  const auto color = made.find<openvdb::Vec3SGrid>("Cd");
  const auto id = made.find<openvdb::Int32Grid>("id");
  int inside = 0, inside_alike = 0, outside = 0, outside_alike = 0;
  for (auto it = color->cbeginValueOn(); it; ++it) {
    const auto at = it.getCoord();
    if (at.x() >= 16) continue;
    const auto there = at.offsetBy(16, 0, 0);
    const bool alike = *it == color->tree().getValue(there);
    const int a = id->tree().getValue(at), b = id->tree().getValue(there);
    if (a == 0 && b == 1) ++inside, inside_alike += alike;
    if (a < 0 && b < 0) ++outside, outside_alike += alike;
  }
  EXPECT_GT(inside, 500);
  EXPECT_LT(inside_alike, inside / 4);  // black stays black
  EXPECT_EQ(outside_alike, outside);    // the binder is one body with tiled detail
}

TEST(LatticeResidual, DarkParticlesStayDark) {
  Particles p = test::one_particle(Vec3::Constant(1.6), Vec3::Constant(0.8), 1.2);
  p.color[0] = Vec3f::Constant(0.02f);
  p.binder_color = Vec3f::Constant(0.6f);
  Volume v = noise(32, 0.05);
  auto scaled = v.find<openvdb::Vec3SGrid>("residual")->deepCopy();
  for (auto it = scaled->beginValueOn(); it; ++it) it.setValue(*it * 0.04f);
  v.grids = {scaled};
  VoxelReport report;
  const Volume made =
      voxelize::voxelize(p, test::shapes_of(test::cube_mesh()), &v, choose_lattice(p.box, {32}), report);
  const auto density = made.find<openvdb::FloatGrid>("density");
  double dark = 0, n = 0;
  for (auto it = made.find<openvdb::Vec3SGrid>("Cd")->cbeginValueOn(); it; ++it)
    if (density->tree().getValue(it.getCoord()) == 1) dark += (*it)[0], ++n;
  EXPECT_NEAR(dark / n, 0.02, 0.003);  // adding and clipping in linear light would give 0.03
}

TEST(LatticeResidual, BadResidualsAreSaid) {
  const Lattice l{Vec3i::Constant(8), 0.1};
  const auto code = [&](Volume v) { return test::code_of([&] { LatticeResidual d(v, l, {}); }); };
  EXPECT_EQ(code({}), "no-residual");
  Volume v = noise(4, 0.1);
  v.resolution = Vec3i::Zero();
  EXPECT_EQ(code(v), "bad-residual");
  v = noise(4, 0.1);
  auto grid = v.find<openvdb::Vec3SGrid>("residual")->deepCopy();
  grid->tree().setValueOn({1, 1, 1}, openvdb::Vec3s(NAN, 0, 0));
  v.grids = {grid};
  EXPECT_EQ(code(v), "bad-residual");
}

}  // namespace
}  // namespace terrazzo

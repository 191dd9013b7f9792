#include "nodes/volumes/phantom/phantom.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/data/volume.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

struct Shares {
  double air = 0, fat = 0, muscle = 0, bone = 0;
};
Shares shares(const std::vector<float>& v, std::size_t begin, std::size_t end) {
  Shares s;
  const double one = 1.0 / static_cast<double>(end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    if (v[i] < -600) s.air += one;
    if (v[i] >= -190 && v[i] < -30) s.fat += one;
    if (v[i] >= -30 && v[i] < 150) s.muscle += one;
    if (v[i] >= 150) s.bone += one;
  }
  return s;
}

TEST(Phantom, HoldsEveryTissueForAnySeed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    phantom::LimbOptions limb;
    limb.resolution = Vec3i(48, 48, 48);
    limb.seed = seed;
    const auto v = phantom::limb(limb);
    const std::size_t slice = 48 * 48;
    const Shares all = shares(v, 0, v.size()), cut = shares(v, 0, slice),
                 end = shares(v, 47 * slice, v.size());
    EXPECT_GT(all.muscle, 0.08);
    EXPECT_GT(all.fat, 0.04);
    EXPECT_GT(all.bone, 0.005);
    EXPECT_GT(cut.muscle, 0.2) << "the cut shows muscle";
    EXPECT_NEAR(end.air, 1, 1e-9) << "it ends before the volume does";
    for (const float x : v) {
      ASSERT_GE(x, -1024);
      ASSERT_LE(x, 3071);
      ASSERT_EQ(x, std::round(x));
    }
  }
}

TEST(Phantom, ScalesWithItsLengthAndStretchesItsVoxels) {
  phantom::LimbOptions a, b;
  a.resolution = b.resolution = Vec3i(24, 24, 36);
  a.noise = b.noise = 0;
  b.length = 120;
  EXPECT_EQ(phantom::limb(a), phantom::limb(b));
  phantom::LimbOptions stretched = a;
  stretched.resolution = Vec3i(24, 24, 6);
  EXPECT_DOUBLE_EQ(stretched.spacing().z(), 40);
  EXPECT_NEAR(shares(phantom::limb(stretched), 0, 24 * 24 * 6).muscle,
              shares(phantom::limb(a), 0, 24 * 24 * 36).muscle, 0.04);
}

TEST(Phantom, NoiseHasTheDeviationAskedFor) {
  phantom::LimbOptions quiet, noisy;
  quiet.resolution = noisy.resolution = Vec3i(32, 32, 32);
  quiet.noise = 0;
  noisy.noise = 12;
  const auto a = phantom::limb(quiet), b = phantom::limb(noisy);
  double sum = 0, squares = 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] > -500) {  // air is clipped at the lower end of the scanner's range
      sum += b[i] - a[i], squares += (b[i] - a[i]) * (b[i] - a[i]), ++n;
    }
  EXPECT_NEAR(sum / double(n), 0, 0.6);
  EXPECT_NEAR(std::sqrt(squares / double(n)), 12, 0.6);
}

TEST(Phantom, GivesASpacedGrid) {
  const auto run = test::run_node("Phantom", {}, {{"resolution", "[16, 16, 8]"}, {"length", "120"}});
  const auto& volume = run.output<Volume>("volume");
  const auto grid = volume.find<openvdb::FloatGrid>("density");
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->activeVoxelCount(), 16u * 16 * 8);
  EXPECT_EQ(grid->voxelSize(), openvdb::Vec3d(5, 5, 15));
  EXPECT_EQ(grid->indexToWorld(openvdb::Vec3d(0)), openvdb::Vec3d(2.5, 2.5, 7.5));
  EXPECT_EQ(test::code_of([] {
              test::run_node("Phantom", {}, {{"resolution", "[16, 8]"}});
            }),
            "bad-resolution");
}

}  // namespace
}  // namespace terrazzo

#include "nodes/bodies/cutting/volume_section.h"

#include <gtest/gtest.h>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/data/volume.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace section;

constexpr int n = 16;
constexpr double voxel = 0.25;

// A periodic volume with a 4 × 6 × 8 block, wrapped, with its corner at `corner`. The color increases along
// x.
Volume block_volume(const openvdb::Coord& corner, bool with_id = true, bool periodic = true) {
  initialize_openvdb();
  auto color = openvdb::Vec3SGrid::create();
  auto density = openvdb::FloatGrid::create();
  auto id = openvdb::Int32Grid::create(-1);
  color->setName("Cd");
  density->setName("density");
  id->setName("id");
  for (int i = 0; i < n * n * n; ++i) {
    const openvdb::Coord c(i % n, i / n % n, i / n / n);
    color->tree().setValue(
        c, openvdb::Vec3s(static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z())));
    auto within = [](int v, int at, int size) { return ((v - at) % n + n) % n < size; };
    if (within(c.x(), corner.x(), 4) && within(c.y(), corner.y(), 6) && within(c.z(), corner.z(), 8)) {
      density->tree().setValue(c, 1.0f);
      id->tree().setValue(c, 7);
    }
  }
  Volume volume;
  if (periodic) volume.resolution = Vec3i::Constant(n);
  for (openvdb::GridBase::Ptr g : std::vector<openvdb::GridBase::Ptr>{color, density, id}) {
    if (g == id && !with_id) continue;
    g->setTransform(voxel_transform(voxel));
    volume.grids.push_back(g);
  }
  return volume;
}

VolumeSection cut(const Volume& v, const std::string& axis, double offset, double pixel) {
  const VolumeBox box = volume_box(v);
  SectionOptions choice;
  choice.axis = axis;
  if (axis != "random") choice.offsets = {offset};
  return cut_volume(v, choose_planes(choice, box.size, box.periodic, pixel));
}

TEST(SectionOfVolume, ReadsVoxelsAtTheirCenters) {
  const Volume v = block_volume({2, 2, 2});
  const VolumeSection s = cut(v, "z", 3.5 * voxel, voxel);
  ASSERT_EQ(s.image.width, n);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) EXPECT_LT((s.image.at(x, n - 1 - y) - Vec3f(x, y, 3)).norm(), 1e-5);
  ASSERT_EQ(s.profiles.profiles.size(), 1u);
  EXPECT_NEAR(s.profiles.profiles[0].area, 24 * voxel * voxel, 1e-12);
  EXPECT_NEAR(s.profiles.profiles[0].centroid.x(), 4 * voxel, 1e-12);
  EXPECT_NEAR(s.profiles.profiles[0].centroid.y(), 5 * voxel, 1e-12);
  EXPECT_NEAR(s.profiles.area_fraction, 24.0 / (n * n), 1e-12);
}

// Phases 0, 1 and 2 in thirds of the period along x.
TEST(SectionOfVolume, PhasesAreClasses) {
  Volume v = block_volume({2, 2, 2}, false);
  auto phase = openvdb::Int32Grid::create();
  phase->setName("phase");
  phase->setTransform(voxel_transform(voxel));
  for (int i = 0; i < n * n * n; ++i)
    phase->tree().setValue(openvdb::Coord(i % n, i / n % n, i / n / n), i % n * 3 / n);
  v.grids.push_back(phase);
  const VolumeSection s = cut(v, "z", 3.5 * voxel, voxel);
  EXPECT_EQ(s.label_grid, "phase");
  ASSERT_EQ(s.labels.classes, (std::vector<std::int32_t>{0, 1}));
  for (int x = 0; x < n; ++x) EXPECT_EQ(s.labels.ids[x], x * 3 / n);
  EXPECT_EQ(s.profiles.classes, 2);
  EXPECT_EQ(s.profiles.profiles[1].cls, 1);
  EXPECT_EQ(std::get<double>(s.table.rows[1][2]), 1);

  v.grids = {phase};  // without colors, phases are gray levels
  const VolumeSection gray = cut(v, "z", 3.5 * voxel, voxel);
  for (int x = 0; x < n; ++x) EXPECT_NEAR(gray.image.at(x, 0)[0], x * 3 / n / 2.0, 1e-6);
  phase->tree().setValue(openvdb::Coord(0, 0, 0), 256);
  EXPECT_EQ(test::code_of([&] { cut(v, "z", 3.5 * voxel, voxel); }), "too-many-phases");
}

TEST(SectionOfVolume, AxesAreSeenAsExemplarsOfSolidTexturesAre) {
  const Volume v = block_volume({2, 2, 2});
  for (int a = 0; a < 3; ++a) {
    const VolumeSection s = cut(v, std::string(1, "xyz"[a]), 3.5 * voxel, voxel);
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        Vec3f at;
        at[a] = 3;
        at[kSliceColumns[a]] = static_cast<float>(x);
        at[kSliceRows[a]] = static_cast<float>(y);
        ASSERT_LT((s.image.at(x, n - 1 - y) - at).norm(), 1e-5) << a;
      }
  }
}

TEST(SectionOfVolume, InterpolatesBetweenVoxelsAndAcrossThePeriod) {
  const Volume v = block_volume({2, 2, 2});
  const VolumeSection s = cut(v, "z", 4 * voxel, voxel / 2);
  EXPECT_NEAR(s.image.at(5, 0).z(), 3.5f, 1e-5);
  EXPECT_NEAR(s.image.at(5, 0).x(), 2.25f, 1e-5);
  EXPECT_NEAR(s.image.at(0, 0).x(), 0.25f * (n - 1), 1e-4);  // a quarter of the voxel at the opposite side
}

TEST(SectionOfVolume, ABlockAcrossTheEdgeIsOneProfile) {
  const Volume v = block_volume({14, 13, 0});
  for (bool with_id : {true, false}) {
    const VolumeSection s = cut(block_volume({14, 13, 0}, with_id), "z", 0.5 * voxel, voxel);
    ASSERT_EQ(s.profiles.profiles.size(), 1u);
    EXPECT_FALSE(s.profiles.profiles[0].touches_border);
    EXPECT_NEAR(s.profiles.profiles[0].centroid.x(), 0, 1e-9);
    EXPECT_NEAR(s.profiles.profiles[0].centroid.y(), 0, 1e-9);
    EXPECT_EQ(s.label_grid, with_id ? "id" : "density");
  }
  EXPECT_EQ(v.grids.size(), 3u);
}

// A ball of voxels, cut obliquely and at the boundary of two layers. Neither cut may fray or shrink it.
TEST(SectionOfVolume, ABallStaysWholeWhereverItIsCut) {
  Volume v = block_volume({0, 0, 0});
  auto id = openvdb::Int32Grid::create(-1);
  id->setName("id");
  id->setTransform(voxel_transform(voxel));
  for (int i = 0; i < n * n * n; ++i) {
    const openvdb::Coord c(i % n, i / n % n, i / n / n);
    if ((c.asVec3d() - openvdb::Vec3d(8)).length() < 6) id->tree().setValue(c, 3);
  }
  v.grids[2] = id;
  const VolumeSection flat = cut(v, "z", 8 * voxel, voxel);  // between layers 7 and 8
  ASSERT_EQ(flat.profiles.profiles.size(), 1u);
  double layer = 0;
  for (int i = 0; i < n * n; ++i) layer += (i % n - 8) * (i % n - 8) + (i / n - 8) * (i / n - 8) < 36;
  EXPECT_NEAR(flat.profiles.profiles[0].area, layer * voxel * voxel, 1e-12);
  SectionOptions choice;
  choice.axis = "random";
  choice.planes = 40;
  const VolumeBox box = volume_box(v);
  const VolumeSection s = cut_volume(v, choose_planes(choice, box.size, box.periodic, voxel / 4));
  // A window of 4 × 4 mm rarely shows more than four periodic images of the ball, each as one region.
  EXPECT_LT(s.profiles.profiles.size(), 40 * 3u);
  int specks = 0;  // allowed only where a plane grazes the ball
  for (const Profile& p : s.profiles.profiles) specks += p.area < voxel * voxel;
  EXPECT_LE(specks, 6);
}

TEST(SectionOfVolume, WithoutPeriodTheBorderCuts) {
  const Volume v = block_volume({0, 4, 0}, true, false);
  const VolumeSection s = cut(v, "z", 0.5 * voxel, voxel);
  ASSERT_EQ(s.profiles.profiles.size(), 1u);
  EXPECT_TRUE(s.profiles.profiles[0].touches_border);
  EXPECT_EQ(s.profiles.profiles[0].weight, 0);
}

TEST(SectionOfVolume, NodeTakesAVolumeAndOnlyThat) {
  const Value v = Value::of(block_volume({2, 2, 2}));
  const auto run = test::run_node("Section", {{"volume", v}}, {{"axis", "random"}, {"planes", "3"}});
  EXPECT_EQ(run.output<Image>("image").sections, 3);
  EXPECT_GT(run.metrics.at("area_fraction"), 0);
  Particles p;
  p.box = Vec3::Ones();
  p.resize(1);
  EXPECT_THROW(test::run_node("Section", {{"volume", v}, {"particles", Value::of(p)}}), Error);
  EXPECT_THROW(test::run_node("Section", {{"volume", Value::of(Volume{})}}), Error);
  Volume other = block_volume({2, 2, 2});
  other.grids = {other.grids[2]};
  try {
    test::run_node("Section", {{"volume", Value::of(other)}});
    FAIL() << "a volume with only ids must be an error";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "no-color");
  }
}

// A solid texture has no particles, so there is no warning about missing ones.
TEST(SectionOfVolume, OfColorsAloneThereIsNothingToWarnOf) {
  Volume v = block_volume({2, 2, 2});
  v.grids.resize(1);
  const auto run = test::run_node("Section", {{"volume", Value::of(v)}});
  EXPECT_TRUE(run.warnings.empty());
  EXPECT_TRUE(run.metrics.empty());
  EXPECT_TRUE(run.output<Profiles>("profiles").profiles.empty());
  EXPECT_EQ(run.output<Image>("image").width, n);
}

}  // namespace
}  // namespace terrazzo

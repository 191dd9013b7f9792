// The node's measures of phases and interfaces.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>

#include "graph/diagnostic.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/packing/measure3d/phase_measures.h"
#include "nodes/packing/measure3d/surfaces.h"
#include "tests/nodes/packing/measure3d/blocks.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using test::NodeRun;

NodeRun measure(const Value& volume, const std::map<std::string, std::string>& parameters = {},
                int threads = 0) {
  return test::run_node("Measure3D", {{"volume", volume}}, parameters, {}, threads);
}

std::string phase_of(const Table& t, std::size_t row) { return std::get<std::string>(t.rows[row][0]); }

// A ball (85) that wraps, a slab (170), and pores.
std::int32_t electrode(const Vec3i& v) {
  if ((nearest_image(v.cast<double>() + Vec3::Constant(0.5) - Vec3(1, 14, 2), Vec3(40, 40, 40))).norm() < 10)
    return 85;
  return v.y() >= 32 ? 170 : 0;
}

TEST(Measure3DPhases, AndTheirInterfacesAreMeasuredByLabel) {
  const auto run =
      measure(Value::of(test::label_volume(Vec3i::Constant(40), 0.5, true, [](int x, int y, int z) {
        return electrode({x, y, z});
      })));
  const auto& t = run.output<Table>("phases");
  ASSERT_EQ(t.rows.size(), 3u);
  EXPECT_EQ(phase_of(t, 0), "0");
  EXPECT_EQ(phase_of(t, 1), "85");
  EXPECT_EQ(phase_of(t, 2), "170");
  const double ball = 4 * M_PI * 25, box = 20 * 20 * 20;
  EXPECT_NEAR(t.number(1, "fraction"), 4.0 / 3 * M_PI * 125 / box, 0.001);
  EXPECT_NEAR(t.number(2, "fraction"), 0.2, 1e-9);
  EXPECT_NEAR(t.number(1, "surface 1/mm") * box / ball, 1, 0.02);
  EXPECT_NEAR(t.number(1, "curvature 1/mm²") * box / (4 * M_PI * 5), 1, 0.02);
  EXPECT_NEAR(t.number(1, "euler 1/mm³") * box, 1, 1e-6);
  EXPECT_NEAR(t.number(1, "chord_y mm"), 20.0 / 3, 0.15);
  EXPECT_NEAR(t.number(1, "thickness mm"), 10, 0.8);  // edges of voxels are thinner
  EXPECT_NEAR(t.number(2, "thickness mm"), 4, 1e-6);
  EXPECT_NEAR(t.number(2, "chord_y mm"), 4, 1e-9);
  EXPECT_EQ(std::get<std::string>(t.rows[2][static_cast<std::size_t>(t.column("chord_x mm"))]), "");
  for (const auto& [row, x, y] : {std::tuple(0u, 1, 0), std::tuple(1u, 0, 0), std::tuple(2u, 1, 0)}) {
    EXPECT_EQ(t.number(row, "percolation_x"), x);
    EXPECT_EQ(t.number(row, "percolation_y"), y);
    EXPECT_EQ(t.number(row, "largest_share"), 1);
  }
  const auto& contact = run.output<Table>("interfaces");
  ASSERT_EQ(contact.rows.size(), 2u);
  EXPECT_EQ(std::get<std::string>(contact.rows[0][1]), "85");
  EXPECT_NEAR(contact.number(0, "area mm²") / ball, 1, 0.02);
  EXPECT_NEAR(contact.number(1, "area mm²") / 800, 0.927, 0.003);  // the worst case of 13 directions
  EXPECT_NEAR(contact.number(1, "area per volume 1/mm"), contact.number(1, "area mm²") / box, 1e-9);
}

TEST(Measure3DPhases, SurfacesAreTheSumsOfTheirInterfaces) {
  for (const bool periodic : {true, false}) {
    const auto c =
        test::classes_of({20, 18, 16}, Vec3(0.5, 0.4, 0.6), periodic, test::random_labels(4, 2, 9));
    const auto cubes = measure3d::count_cubes(c, {});
    std::vector<double> sum(4, 0);
    for (const auto& i : measure3d::interfaces_of(c, {})) {
      sum[static_cast<std::size_t>(i.a)] += i.per_volume;
      sum[static_cast<std::size_t>(i.b)] += i.per_volume;
      EXPECT_LT(i.a, i.b);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const double surface = measure3d::minkowski_densities(cubes[k], c.box.spacing, false).surface;
      // Pairs at the border are in fewer cubes, so both agree only on average there.
      EXPECT_NEAR(sum[k] / surface, 1, periodic ? 1e-9 : 0.03) << k;
    }
  }
}

std::vector<std::vector<Table::Cell>> rows_of(const NodeRun& run, const char* output) {
  return run.output<Table>(output).rows;
}

TEST(Measure3DPhases, DoNotDependOnThreadsOrTheOriginOfThePeriod) {
  const Vec3i n(36, 30, 28);
  const auto at = [&](const Vec3i& shift) {
    const auto blobs = test::random_labels(3, 4, 11);
    return Value::of(test::label_volume(n, 0.5, true, [&](int x, int y, int z) {
      return blobs(wrap_index(x + shift.x(), n.x()), wrap_index(y + shift.y(), n.y()),
                   wrap_index(z + shift.z(), n.z())) -
             1;
    }));
  };
  const NodeRun one = measure(at({0, 0, 0}), {}, 1);
  for (const int threads : {2, 7}) {
    const NodeRun more = measure(at({0, 0, 0}), {}, threads);
    for (const char* output : {"table", "phases", "interfaces", "distributions"})
      EXPECT_EQ(rows_of(one, output), rows_of(more, output)) << output << threads;
  }
  const NodeRun moved = measure(at({13, 7, 21}));
  EXPECT_EQ(rows_of(one, "interfaces"), rows_of(moved, "interfaces"));
  const auto &before = one.output<Table>("phases"), &after = moved.output<Table>("phases");
  ASSERT_EQ(before.rows.size(), 3u);
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t k = 0; k < before.columns.size(); ++k) {
      const std::string& name = before.columns[k];
      if (name == "thickness mm" || name == "thickness_sd mm")  // sums over voxels in another order
        EXPECT_NEAR(before.number(row, name), after.number(row, name), 1e-9);
      else
        EXPECT_EQ(before.rows[row][k], after.rows[row][k]) << row << name;
    }
}

TEST(Measure3DPhases, OfTurnedVolumesAreTurned) {
  const auto blobs = test::random_labels(2, 3, 5);
  const Vec3i n(20, 24, 28);
  const Vec3 spacing(0.5, 0.75, 1);
  const auto c = test::classes_of(n, spacing, true, blobs);
  const auto turned = test::classes_of({28, 20, 24}, {1, 0.5, 0.75}, true,
                                       [&](int z, int x, int y) { return blobs(x, y, z); });
  const auto before = measure3d::measure_classes(c, test::kPlenty, {}),
             after = measure3d::measure_classes(turned, test::kPlenty, {});
  for (std::size_t k = 0; k < 2; ++k) {
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(before[k].chords[a].mean, after[k].chords[(a + 1) % 3].mean);
      EXPECT_EQ(before[k].chords[a].share, after[k].chords[(a + 1) % 3].share);
      EXPECT_EQ(before[k].percolation.across[a], after[k].percolation.across[(a + 1) % 3]);
    }
    EXPECT_NEAR(before[k].thickness.mean, after[k].thickness.mean, 1e-6);
    EXPECT_NEAR(before[k].densities.euler, after[k].densities.euler, 1e-9);
    // The shares of directions are sampled.
    EXPECT_NEAR(before[k].densities.surface / after[k].densities.surface, 1, 1e-3);
    EXPECT_NEAR(before[k].densities.curvature, after[k].densities.curvature,
                2e-3 * before[k].densities.surface);
  }
}

TEST(Measure3DPhases, OfADensityAreThePhaseAndTheRest) {
  Volume v;
  add_number_grid(v, "density", Vec3i(10, 8, 8), Vec3::Ones(), {},
                  [](std::size_t i) { return static_cast<float>(i % 10) / 10; });
  v.resolution = Vec3i(10, 8, 8);
  const auto run = measure(Value::of(v), {{"threshold", "0.55"}});
  const auto& t = run.output<Table>("phases");
  ASSERT_EQ(t.rows.size(), 2u);
  EXPECT_EQ(phase_of(t, 0), "rest");
  EXPECT_EQ(phase_of(t, 1), "particles");
  EXPECT_NEAR(t.number(1, "fraction"), 0.4, 1e-12);
  EXPECT_NEAR(t.number(1, "thickness mm"), 4, 1e-6);
  EXPECT_NEAR(run.metrics.at("mean_chord_x"), 4, 1e-12);
  EXPECT_EQ(run.metrics.count("mean_chord_y"), 0u);
  EXPECT_NEAR(run.metrics.at("mean_thickness"), 4, 1e-6);
  EXPECT_NEAR(run.metrics.at("euler_density"), 0, 1e-12);
  EXPECT_NEAR(run.metrics.at("curvature_density"), 0, 1e-12);
  EXPECT_EQ(run.metrics.at("percolation_x"), 0);
  EXPECT_EQ(run.metrics.at("percolation_y"), 1);
  EXPECT_EQ(run.metrics.at("largest_share"), 1);
  EXPECT_EQ(run.output<Table>("interfaces").rows.size(), 1u);
  EXPECT_GT(run.output<Image>("figure").width, 0);
}

// More labels than are measured one by one are the phase and the rest, and the phase is the same either way.
TEST(Measure3DPhases, OfManyLabelsAreTogether) {
  const auto cubes = [](int count) {
    return Value::of(test::label_volume(Vec3i::Constant(30), 1, true, [=](int x, int y, int z) {
      const bool in = x % 6 < 4 && y % 6 < 4 && z % 6 < 4;
      return in ? (x / 6 + 5 * (y / 6) + 25 * (z / 6)) % count : -1;
    }));
  };
  const NodeRun many = measure(cubes(125)), few = measure(cubes(63)), one = measure(cubes(1));
  EXPECT_EQ(many.output<Table>("phases").rows.size(), 2u);
  EXPECT_EQ(few.output<Table>("phases").rows.size(), 64u);
  EXPECT_EQ(few.output<Table>("interfaces").rows.size(), 63u);
  EXPECT_EQ(phase_of(few.output<Table>("phases"), 0), "binder");
  for (const char* name : {"mean_chord", "mean_chord_x", "mean_thickness", "euler_density",
                           "curvature_density", "percolation_x", "voxel_surface", "largest_share"}) {
    EXPECT_EQ(many.metrics.at(name), few.metrics.at(name)) << name;
    EXPECT_EQ(many.metrics.at(name), one.metrics.at(name)) << name;
  }
  EXPECT_NEAR(many.metrics.at("euler_density"), 125.0 / 27000, 1e-12);
  EXPECT_NEAR(many.metrics.at("largest_share"), 1.0 / 125, 1e-12);
}

TEST(Measure3DPhases, StopWhenCanceled) {
  const auto c = test::classes_of({12, 12, 12}, Vec3::Ones(), true, test::random_labels(3, 2, 4));
  const std::atomic<bool> canceled = true;
  const Work work(&canceled, nullptr);
  EXPECT_THROW(measure3d::chord_lengths(c, work), Cancelled);
  EXPECT_THROW(measure3d::count_cubes(c, work), Cancelled);
  EXPECT_THROW(measure3d::percolation_of(c, test::kPlenty, work), Cancelled);
  EXPECT_THROW(measure3d::local_thickness(c, test::kPlenty, work), Cancelled);
  EXPECT_THROW(measure3d::interfaces_of(c, work), Cancelled);
}

TEST(Measure3DPhases, OfTheElectrodeAreThoseOfTheFile) {
  const auto path = test::shared_data() / "media" / "electrode.tiff";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
  const auto volume =
      test::run_node("LoadVolume", {}, {{"path", path.string()}, {"grid", "id"}, {"spacing", "0.001"}});
  const auto raster = measure3d::read_raster(volume.output<Volume>("volume"), "", nullptr,
                                             measure3d::Phase::Particles, {}, test::kPlenty, {});
  const auto phases = measure3d::classes_of_labels(raster, {});
  ASSERT_TRUE(phases);
  EXPECT_EQ(phases->name, (std::vector<std::string>{"0", "85", "170"}));
  const double fractions[] = {0.450, 0.400, 0.150};
  const auto percolation = measure3d::percolation_of(*phases, test::kPlenty, {});
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(static_cast<double>(phases->voxels[k]) / 16777216, fractions[k], 0.0005);
    for (const double share : percolation[k].across) EXPECT_GT(share, 0.95);
  }
}

}  // namespace
}  // namespace terrazzo

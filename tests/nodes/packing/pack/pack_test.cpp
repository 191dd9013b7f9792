// Which method Pack chooses, and that each one delivers.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "nodes/packing/pack/choose.h"
#include "nodes/packing/rigid/audit.h"
#include "tests/nodes/packing/anneal/packing_support.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

test::NodeRun pack_any(double fraction, std::map<std::string, std::string> settings = {},
                       const Profiles* profiles = nullptr) {
  const Shapes shapes = test::shapes_of({test::ellipsoid(2)});
  const SizeDistribution d = test::distribution(shapes, 1, 1.6, fraction);
  settings.emplace("count", "80");
  std::multimap<std::string, Value> inputs{{"shapes", Value::of<Shapes>(shapes)},
                                           {"distribution", Value::of<SizeDistribution>(d)}};
  if (profiles) inputs.emplace("profiles", Value::of<Profiles>(*profiles));
  return test::run_node("Pack", inputs, settings, {}, 2);
}

// Twelve ellipses of 64 points, in rows of four.
Profiles ellipses(double axis_ratio) {
  Profiles out;
  for (int k = 0; k < 12; ++k) {
    Profile p;
    for (int i = 0; i < 64; ++i) {
      const double t = 2 * std::numbers::pi * i / 64;
      p.contour.push_back(Vec2(3.0 * (k % 4) + std::cos(t), 3.0 * (k / 4) + axis_ratio * std::sin(t)));
    }
    out.profiles.push_back(std::move(p));
  }
  return out;
}

TEST(Pack, ChoosesByDensity) {
  const std::map<double, std::string> expected{{0.35, "by_anneal"}, {0.8, "by_grow"}, {0.985, "by_laguerre"}};
  for (const auto& [fraction, method] : expected) {
    const auto run = pack_any(fraction);
    for (const char* m : {"by_anneal", "by_grow", "by_laguerre", "by_deposit"})
      EXPECT_EQ(run.metrics.at(m), m == method) << fraction << " " << m;
    EXPECT_NEAR(run.metrics.at("packing_fraction"), fraction, 0.005);
    EXPECT_EQ(run.warnings.empty(), method == "by_anneal");
    EXPECT_LT(packing::audit(run.output<Shapes>("shapes"), run.output<Particles>("particles")).worst, 1e-4);
  }
}

// Half of the surface in the photograph is light soil.
Profiles in_soil(double axis_ratio) {
  Profiles surface = ellipses(axis_ratio);
  surface.view = View::Surface;
  surface.window = Vec2(9, 7);
  surface.area_fraction = 0.5;
  surface.binder_color = Vec3f::Constant(0.6f);
  for (Profile& p : surface.profiles) p.color = Vec3f::Constant(0.3f);
  return surface;
}

// Stones in soil never grow into each other: they lie flat in a bed as wide as the photograph, as dense as
// fits.
TEST(Pack, StonesInSoilLieFlat) {
  const Profiles surface = in_soil(0.9);
  const auto bed = pack_any(0.5, {}, &surface);
  EXPECT_EQ(bed.metrics.at("by_anneal"), 1);
  EXPECT_NEAR(bed.metrics.at("packing_fraction"), 0.5, 0.01);
  EXPECT_NEAR(bed.metrics.at("box_x"), 9, 1e-9);
  EXPECT_NEAR(bed.metrics.at("box_y"), 9 * 50 / 64.0, 1e-9);  // 7, in sixty-fourths of 9
  const auto dense = pack_any(0.85, {}, &surface);
  EXPECT_EQ(dense.metrics.at("by_anneal"), 1);
  EXPECT_LT(dense.metrics.at("packing_fraction"), 0.8);
  EXPECT_LT(packing::audit(dense.output<Shapes>("shapes"), dense.output<Particles>("particles")).worst, 1e-4);
}

TEST(Pack, LooseStonesFall) {
  Profiles surface = in_soil(0.9);
  surface.area_fraction = 0.95;
  const auto fallen = pack_any(0.58, {}, &surface);
  EXPECT_EQ(fallen.metrics.at("by_deposit"), 1);
  EXPECT_NEAR(fallen.metrics.at("box_x"), 9, 1e-9);
  const Particles& stones = fallen.output<Particles>("particles");
  double lowest = 1e9;
  for (const Vec3& at : stones.position) lowest = std::min(lowest, at.z());
  EXPECT_LT(lowest, 0.5 * stones.size[0]);  // on the floor
  const auto chosen = pack_any(0.58, {{"method", "deposit"}, {"size", "[9, 7, 4]"}});
  EXPECT_EQ(chosen.metrics.at("by_deposit"), 1);
  EXPECT_NEAR(chosen.metrics.at("box_y"), 7, 1e-9);
}

// The flat sides of stones that are packed densely stay down, and their long axes where the photograph's
// point.
TEST(Pack, StonesInSoilKeepTheirDirection) {
  const Profiles surface = in_soil(0.5);
  const auto bed = pack_any(0.6, {}, &surface);
  const Particles& stones = bed.output<Particles>("particles");
  int along = 0;
  for (const Quat& turn : stones.orientation) along += std::abs((turn * Vec3::UnitX()).x()) > 0.75;
  EXPECT_GT(along, 0.9 * stones.count());
}

TEST(Pack, DenseEquiaxedParticlesAreCellsWithJoints) {
  const Profiles round = ellipses(0.9), flat = ellipses(0.4);
  EXPECT_NEAR(pack::usual_axis_ratio(round), 0.9, 0.01);
  EXPECT_NEAR(pack::usual_axis_ratio(flat), 0.4, 0.01);
  Profiles cut = round;
  for (Profile& p : cut.profiles) p.touches_border = true;
  EXPECT_EQ(pack::usual_axis_ratio(cut), 0);
  const auto dense = pack_any(0.82, {}, &round);
  EXPECT_EQ(dense.metrics.at("by_laguerre"), 1);
  EXPECT_GT(dense.metrics.at("gap"), 0);
  EXPECT_GT(dense.metrics.at("roundness"), 0.05);
  EXPECT_NEAR(dense.metrics.at("packing_fraction"), 0.82, 0.005);
  EXPECT_LT(packing::audit(dense.output<Shapes>("shapes"), dense.output<Particles>("particles")).worst, 1e-4);
  EXPECT_EQ(pack_any(0.82, {}, &flat).metrics.at("by_grow"), 1);
  EXPECT_EQ(pack_any(0.35, {}, &round).metrics.at("by_anneal"), 1);
}

// Particles that jam stay rigid if a photograph of so few profiles cannot tell the difference in fraction.
TEST(Pack, JammedParticlesStayRigidWithinTheErrorOfThePhotograph) {
  Profiles seen = ellipses(0.9);
  seen.area_fraction = 0.71;
  for (Profile& p : seen.profiles) p.area = 2;
  EXPECT_NEAR(pack::fraction_error(seen), 0.71 * 0.29 / std::sqrt(12.0), 1e-9);
  EXPECT_EQ(pack::fraction_error({}), 0);
  const auto rigid = pack_any(0.71, {}, &seen);
  EXPECT_EQ(rigid.metrics.at("by_anneal"), 1);
  EXPECT_LT(rigid.metrics.at("packing_fraction"), 0.7);
  EXPECT_GT(rigid.metrics.at("packing_fraction"), 0.71 - pack::fraction_error(seen));
  EXPECT_EQ(pack_any(0.71).metrics.at("by_grow"), 1);
}

TEST(Pack, MethodsCanBeForced) {
  EXPECT_EQ(pack_any(0.3, {{"method", "laguerre"}}).metrics.at("by_laguerre"), 1);
  EXPECT_EQ(pack_any(0.3, {{"method", "grow"}}).metrics.at("by_grow"), 1);
  const auto rigid = pack_any(0.9, {{"method", "anneal"}, {"count", "25"}});
  EXPECT_EQ(rigid.metrics.at("by_anneal"), 1);
  EXPECT_LT(rigid.metrics.at("shrink"), 1);
  EXPECT_EQ(test::code_of([] {
              pack_any(0.9, {{"method", "anneal"}, {"on_jam", "fail"}, {"count", "25"}});
            }),
            "jammed");
}

TEST(Pack, RigidParticlesKeepTheGivenShapes) {
  const auto run = pack_any(0.35);
  EXPECT_EQ(run.output<Shapes>("shapes").shapes.size(), 1u);
  const auto& table = run.output<Table>("table");
  ASSERT_EQ(table.rows.size(), run.output<Particles>("particles").count());
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    EXPECT_NEAR(table.number(i, "volume mm³"), table.number(i, "volume_wanted mm³"),
                1e-9 * table.number(i, "volume mm³"));
}

}  // namespace
}  // namespace terrazzo

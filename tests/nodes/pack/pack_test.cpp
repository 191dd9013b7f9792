// Which method Pack chooses, and that each one delivers.
#include <gtest/gtest.h>

#include "nodes/packing/audit.h"
#include "tests/nodes/anneal/packing_support.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

test::NodeRun pack_any(double fraction, std::map<std::string, std::string> settings = {}) {
  const Shapes shapes = test::shapes_of({test::ellipsoid(2)});
  const SizeDistribution d = test::distribution(shapes, 1, 1.6, fraction);
  settings.emplace("count", "80");
  return test::run_node(
      "Pack", {{"shapes", Value::of<Shapes>(shapes)}, {"distribution", Value::of<SizeDistribution>(d)}},
      settings, {}, 2);
}

TEST(Pack, ChoosesByDensity) {
  const std::map<double, std::string> expected{{0.35, "by_anneal"}, {0.8, "by_grow"}, {0.985, "by_laguerre"}};
  for (const auto& [fraction, method] : expected) {
    const auto run = pack_any(fraction);
    for (const char* m : {"by_anneal", "by_grow", "by_laguerre"})
      EXPECT_EQ(run.metrics.at(m), m == method) << fraction << " " << m;
    EXPECT_NEAR(run.metrics.at("packing_fraction"), fraction, 0.005);
    EXPECT_EQ(run.warnings.empty(), method == "by_anneal");
    EXPECT_LT(packing::audit(run.output<Shapes>("shapes"), run.output<Particles>("particles")).worst, 1e-4);
  }
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

// What Unfold says about its result.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "nodes/data/table.h"
#include "nodes/sizes/unfold/summary.h"
#include "tests/nodes/sizes/unfold/spheres.h"
#include "tests/nodes/sizes/unfold/spheres_section.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

test::NodeRun unfolded(const Profiles& p, const KMatrix& k,
                       std::map<std::string, std::string> parameters = {}) {
  parameters["bootstrap"] = "0";
  return test::run_node("Unfold", {{"profiles", Value::of(p)}, {"kmatrix", Value::of(k)}}, parameters);
}

bool warns(const test::NodeRun& run, const std::string& of) {
  return std::any_of(run.warnings.begin(), run.warnings.end(),
                     [&](const std::string& w) { return w.find(of) != std::string::npos; });
}

const KMatrix& of_shape(const std::string& kind) {
  static std::map<std::string, KMatrix> known;
  if (!known.count(kind)) {
    const auto shapes = test::run_node("Shape", {}, {{"kind", kind}, {"size", "1"}}).outputs.at("shapes");
    known[kind] = kmatrix::make_kmatrix(shapes.as<Shapes>(), {.classes = 10});
  }
  return known[kind];
}

TEST(UnfoldWarnings, ColumnsOfRelativeDensitiesHaveNoUnit) {
  Profiles p = test::section(5, 10, 0.001, 1e5, 3);
  const auto columns = [&] { return unfolded(p, test::spheres<10>()).output<Table>("table").columns; };
  const auto has = [](const std::vector<std::string>& all, const std::string& name) {
    return std::find(all.begin(), all.end(), name) != all.end();
  };
  EXPECT_TRUE(has(columns(), "N_V mm⁻³"));
  p.observed_area = 0;
  p.area_fraction = 0;
  const auto relative = columns();
  for (const char* name : {"N_A observed relative", "N_A refitted relative", "N_V relative",
                           "N_V low relative", "N_V high relative"})
    EXPECT_TRUE(has(relative, name)) << name;
  for (const std::string& name : relative) EXPECT_EQ(name.find("mm⁻"), std::string::npos) << name;
}

TEST(UnfoldWarnings, RoundParticlesCannotFillSpace) {
  Profiles p = test::section(2, 10, 0.001, 1e5, 7);
  const double covered = p.area_fraction * p.observed_area;
  const auto at = [&](double fraction, const KMatrix& k) {
    p.observed_area = covered / fraction;
    p.area_fraction = fraction;
    return unfolded(p, k);
  };
  EXPECT_TRUE(warns(at(0.98, test::spheres<10>()), "ShapeFamilies"));
  EXPECT_FALSE(warns(at(0.6, test::spheres<10>()), "ShapeFamilies"));
  EXPECT_FALSE(warns(at(0.98, of_shape("octahedron")), "ShapeFamilies"));  // no rounder than cells
}

TEST(UnfoldWarnings, SphericityIsThatOfConvexBodies) {
  EXPECT_NEAR(unfold::sphericity(test::spheres<10>()), 1, 0.02);
  EXPECT_NEAR(unfold::sphericity(of_shape("box")), 1 / (std::numbers::pi / 6 * std::pow(1.5, 3)), 1e-3);
  EXPECT_EQ(unfold::sphericity({}), 0);
}

TEST(UnfoldWarnings, PoorFitsAreNamed) {
  Profiles p;
  p.observed_area = 1e7;
  p.profiles.resize(20000);
  for (auto& q : p.profiles) q.area = std::numbers::pi / 4 * 36;  // spheres would have smaller profiles too
  p.area_fraction = 20000 * p.profiles[0].area / p.observed_area;
  const auto poor = unfolded(p, test::spheres<10>(), {{"d_max", "10"}, {"smallest_visible", "0"}});
  EXPECT_GT(poor.metrics.at("goodness_of_fit"), 100);
  EXPECT_TRUE(warns(poor, "goodness_of_fit is"));
  const auto good = unfolded(test::section(5, 10, 0.001, 1e5, 3), test::spheres<10>());
  EXPECT_LT(good.metrics.at("goodness_of_fit"), 3);
  EXPECT_FALSE(warns(good, "goodness_of_fit is"));
}

}  // namespace
}  // namespace terrazzo

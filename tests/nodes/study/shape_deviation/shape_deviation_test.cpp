#include <gtest/gtest.h>

#include "nodes/data/table.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

Table metrics(double a, double b, const std::string& name = "other") {
  Table t;
  t.columns = {"name", "sections", "profiles"};
  for (const char* measure : {"area/perimeter²", "total curvature rad"})
    for (const char* what : {" mean", " sd", " deviation %"})
      t.columns.push_back(std::string(measure) + what);
  const auto row = [&](const std::string& of, const char* sections, double x, double y) {
    t.rows.push_back({of, std::string(sections), 10.0, 1 + x / 100, 0.5, x, 2 + y / 50, 0.5, y});
  };
  row("original", "central", 0, 0);
  row(name, "central", a, b);
  row("original", "random", 0, 0);
  row(name, "random", 2 * a, 2 * b);
  return t;
}

TEST(ShapeDeviation, AveragesAbsoluteDeviations) {
  const auto run = test::run_node(
      "ShapeDeviation", {{"tables", Value::of(metrics(3, -5))}, {"tables", Value::of(metrics(-1, -1))}});
  const auto& t = run.output<Table>("table");
  ASSERT_EQ(t.rows.size(), 4u);
  EXPECT_EQ(t.columns, (std::vector<std::string>{"measure", "sections", "other %", "other signed %"}));
  EXPECT_EQ(t.number(0, "other %"), 2);
  EXPECT_EQ(t.number(1, "other %"), 4);
  EXPECT_EQ(t.number(2, "other %"), 3);
  EXPECT_EQ(t.number(3, "other %"), 6);
  EXPECT_EQ(t.number(0, "other signed %"), 1);
  EXPECT_EQ(t.number(2, "other signed %"), -3);
}

// The analysis from means and standard deviations is that of the values: two methods, two originals, values
// 2, 3 | 3, 4 and 6, 7 | 7, 8, computed by hand as in Anova.BalancedSquaresAddUp.
TEST(ShapeDeviation, TheAnalysisOfVarianceIsThatOfTheSections) {
  const auto table = [](double first, double second) {
    Table t;
    t.columns = {"name", "sections", "profiles", "m mean", "m sd", "m deviation %"};
    for (const char* sections : {"central", "random"}) {
      t.rows.push_back({std::string("original"), std::string(sections), 2.0, 99.0, 5.0, 0.0});
      t.rows.push_back({std::string("a"), std::string(sections), 2.0, first, 0.5, 0.0});
      t.rows.push_back({std::string("b"), std::string(sections), 2.0, second, 0.5, 0.0});
    }
    return t;
  };
  const auto run = test::run_node(
      "ShapeDeviation", {{"tables", Value::of(table(2.5, 6.5))}, {"tables", Value::of(table(3.5, 7.5))}},
      {{"measures", "[m]"}});
  const auto& t = run.output<Table>("anova");
  ASSERT_EQ(t.rows.size(), 6u);
  EXPECT_NEAR(t.number(0, "sum of squares"), 32, 1e-9);
  EXPECT_NEAR(t.number(1, "sum of squares"), 2, 1e-9);
  EXPECT_NEAR(t.number(2, "sum of squares"), 0, 1e-9);
  EXPECT_NEAR(t.number(0, "error sum of squares"), 2, 1e-9);
  EXPECT_EQ(t.number(0, "error degrees of freedom"), 4);
  EXPECT_NEAR(t.number(0, "F"), 64, 1e-6);
  EXPECT_NEAR(t.number(0, "p"), 0.00132390, 1e-7);
  EXPECT_EQ(std::get<std::string>(t.rows[3][1]), "random");
}

TEST(ShapeDeviation, BadInputIsNamed) {
  EXPECT_EQ(test::code_of([] {
              test::run_node("ShapeDeviation", {{"tables", Value::of(metrics(1, 1))},
                                                {"tables", Value::of(metrics(1, 1, "third"))}});
            }),
            "other-methods");
  EXPECT_EQ(test::code_of([] {
              test::run_node("ShapeDeviation", {{"tables", Value::of(Table{})}});
            }),
            "no-tables");
  EXPECT_EQ(
      test::code_of([] {
        test::run_node("ShapeDeviation", {{"tables", Value::of(metrics(1, 1))}}, {{"measures", "[size]"}});
      }),
      "not-metrics");
}

}  // namespace
}  // namespace terrazzo

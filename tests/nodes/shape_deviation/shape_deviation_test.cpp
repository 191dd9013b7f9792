#include <gtest/gtest.h>

#include "nodes/data/table.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

Table metrics(double a, double b, const std::string& name = "other") {
  Table t;
  t.columns = {"name", "sections", "area/perimeter² deviation %", "total curvature rad deviation %"};
  t.rows = {{std::string("original"), std::string("central"), 0.0, 0.0},
            {name, std::string("central"), a, b},
            {std::string("original"), std::string("random"), 0.0, 0.0},
            {name, std::string("random"), 2 * a, 2 * b}};
  return t;
}

TEST(ShapeDeviation, AveragesAbsoluteDeviations) {
  const auto run = test::run_node(
      "ShapeDeviation", {{"tables", Value::of(metrics(3, -5))}, {"tables", Value::of(metrics(-1, -1))}});
  const auto& t = run.output<Table>("table");
  ASSERT_EQ(t.rows.size(), 4u);
  EXPECT_EQ(t.columns, (std::vector<std::string>{"measure", "sections", "other %"}));
  EXPECT_EQ(t.number(0, "other %"), 2);
  EXPECT_EQ(t.number(1, "other %"), 4);
  EXPECT_EQ(t.number(2, "other %"), 3);
  EXPECT_EQ(t.number(3, "other %"), 6);
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

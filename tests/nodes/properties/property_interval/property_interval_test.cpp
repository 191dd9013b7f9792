// Intervals: quantiles from tables, what an interval consists of, and how often it holds the truth.
#include <gtest/gtest.h>

#include <cmath>

#include "nodes/data/table.h"
#include "nodes/properties/property_interval/interval.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace property_interval;

TEST(PropertyInterval, UsesTheQuantilesOfStudent) {
  EXPECT_NEAR(student_quantile(0.95, 1), 6.3138, 1e-4);
  EXPECT_NEAR(student_quantile(0.95, 3), 2.3534, 1e-4);
  EXPECT_NEAR(student_quantile(0.975, 10), 2.2281, 1e-4);
  EXPECT_NEAR(student_quantile(0.95, 1e6), 1.6449, 1e-4);
}

TEST(PropertyInterval, NamesItsParts) {
  // Variances 1 and 4, so that 3 come from the photograph.
  const std::vector<double> blocks{9, 10, 11}, draws{8, 10, 12};
  const Interval i = interval_of(blocks, draws, 0.5, 0.9);
  EXPECT_DOUBLE_EQ(i.estimate, 10);
  EXPECT_DOUBLE_EQ(i.block, 1);
  EXPECT_DOUBLE_EQ(i.photograph, std::sqrt(3));
  const double variance = 3 + 1.0 / 3, freedom = variance * variance / (16.0 / 2 + 4.0 / 9 / 2);
  const double half = std::hypot(student_quantile(0.95, freedom) * std::sqrt(variance), 0.5);
  EXPECT_NEAR(i.high - 10, half, 1e-12);
  EXPECT_NEAR(10 - i.low, half, 1e-12);
  EXPECT_EQ(interval_of(draws, blocks, 0, 0.9).photograph, 0);  // never negative
  EXPECT_EQ(test::code_of([] { interval_of({1}, {1, 2}, 0, 0.9); }), "too-few-values");
}

double normal(Random& r) {
  double sum = 0;
  for (int k = 0; k < 12; ++k) sum += r.uniform();
  return sum - 6;
}

// The photograph is off by a deviation that the draws repeat; blocks scatter on top.
TEST(PropertyInterval, HoldsTheTruthAsOftenAsItSays) {
  for (const double photograph : {0.3, 1.0, 3.0}) {
    int held = 0;
    constexpr int kTrials = 400;
    for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
      Random r(5, 1, trial);
      const double seen = 20 + photograph * normal(r);
      std::vector<double> blocks, draws;
      for (int k = 0; k < 4; ++k) blocks.push_back(seen + normal(r));
      for (int k = 0; k < 8; ++k) draws.push_back(seen + photograph * normal(r) + normal(r));
      const Interval i = interval_of(blocks, draws, 0, 0.9);
      held += i.low <= 20 && 20 <= i.high;
    }
    EXPECT_GT(held, 0.85 * kTrials) << photograph;
    EXPECT_LT(held, 0.99 * kTrials) << photograph;
  }
}

Table table_with(double value, Table::Cell half) {
  return {{"measure", "value", "unit", "half_resolution"},
          {{std::string("effective, mean"), value, std::string(), std::move(half)}}};
}

TEST(PropertyInterval, ReadsTheTablesOfHomogenize) {
  std::multimap<std::string, Value> inputs;
  for (const double v : {9.0, 11.0}) inputs.emplace("blocks", Value::of(table_with(v, std::string())));
  for (const double v : {8.0, 12.0, 10.0}) inputs.emplace("draws", Value::of(table_with(v, std::string())));
  const auto r = test::run_node("PropertyInterval", inputs);
  EXPECT_DOUBLE_EQ(r.metrics.at("estimate"), 10);
  EXPECT_EQ(r.metrics.at("voxels"), 0);
  EXPECT_NEAR(r.metrics.at("representative_blocks"), std::pow(2 * std::sqrt(2) / 0.5, 2), 1e-9);
  EXPECT_EQ(test::code_of([&] {
              test::run_node("PropertyInterval", inputs, {{"measure", "mass"}});
            }),
            "no-measure");
}

// Values that are 1 too large at the blocks' resolution, and 2 at half of it.
TEST(PropertyInterval, ExtrapolatesToSmallVoxels) {
  std::multimap<std::string, Value> inputs;
  for (const double v : {9.0, 11.0}) inputs.emplace("blocks", Value::of(table_with(v + 1, v + 2)));
  for (const double v : {8.0, 12.0, 10.0}) inputs.emplace("draws", Value::of(table_with(v + 1, v + 2)));
  const auto r = test::run_node("PropertyInterval", inputs);
  EXPECT_DOUBLE_EQ(r.metrics.at("estimate"), 10);
  EXPECT_DOUBLE_EQ(r.metrics.at("voxels"), 0.5);
  EXPECT_DOUBLE_EQ(r.output<Table>("table").number(1, "value"), 11);
}

}  // namespace
}  // namespace terrazzo

#include "runtime/sweep/sweep.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace terrazzo {
namespace {
using Words = std::vector<std::string>;

TEST(Sweep, ValuesAreListsOrRanges) {
  EXPECT_EQ(parse_vary("a.b=1,x,[1, 2],\"c,d\"").values, (Words{"1", "x", "[1, 2]", "\"c,d\""}));
  EXPECT_EQ(parse_vary("a.b=0:.3:.1").values, (Words{"0", "0.1", "0.2", "0.3"}));
  EXPECT_EQ(parse_vary("a.b=5:1:-2").values, (Words{"5", "3", "1"}));
  EXPECT_EQ(parse_vary("a.b=1:2:.7").values, (Words{"1", "1.7"}));
  EXPECT_EQ(parse_vary("photo=C:x:y").values, (Words{"C:x:y"}));  // not a range
  EXPECT_EQ(parse_vary("a/b.c=1").target, "a/b.c");
  EXPECT_EQ(parse_values(" 1, 2 ,#aabbcc"), (Words{"1", "2", "#aabbcc"}));
  for (const char* bad : {"a.b", "a.b=", "=1", "a.b=1,,2", "a.b=1:2:0", "a.b=1:2:-1", "a.b=0:1:1e-9"})
    EXPECT_THROW(parse_vary(bad), Error) << bad;
}

TEST(Sweep, EveryCombinationOnce) {
  const SweepPoints points({{"n.a", {"1", "2"}}, {"photo", {"x", "y", "z"}}}, {{{"n.c", "9"}}, {}, {}});
  ASSERT_EQ(points.size(), 6u);
  EXPECT_EQ(points[0].folder, "point-001");
  EXPECT_EQ(points[4].values,
            (std::vector<std::pair<std::string, std::string>>{{"n.a", "2"}, {"photo", "y"}}));
  EXPECT_EQ(points[4].overrides.set.size(), 2u);
  EXPECT_EQ(points[4].overrides.parameters[0].second, "y");
  EXPECT_EQ(points.find("point-004"), 3u);
  EXPECT_EQ(points.find("6"), 5u);
  for (const char* none : {"0", "7", "point-", "x", "1x"}) EXPECT_EQ(points.find(none), std::nullopt) << none;
  EXPECT_THROW(SweepPoints({{"n.a", {"1"}}, {"n.a", {"2"}}}, {}), Error);
}

TEST(Sweep, PartsOfAGraphArePoints) {
  const auto points = SweepPoints::of_parts(
      {{"block[3]", {"block[3]"}}, {"field[a]", {"field[a]/x", "y[a]"}}}, {{{"n.c", "9"}}, {}, {}});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].folder, "point-002");
  EXPECT_EQ(points[1].name(), "field[a]");
  EXPECT_EQ(points[1].caption(), "point-002: element field[a]");
  EXPECT_EQ(points[1].targets, (Words{"field[a]/x", "y[a]"}));
  EXPECT_EQ(points[1].overrides.set.size(), 1u);
  EXPECT_TRUE(points[1].overrides.parameters.empty());
  EXPECT_EQ(points.find("block[3]"), 0u);
  EXPECT_EQ(points.find("point-002"), 1u);
  EXPECT_EQ(points.find("block[4]"), std::nullopt);
}

TEST(Sweep, ChunksContainEveryPointOnce) {
  for (const std::size_t points : {0u, 1u, 7u, 24u})
    for (const std::size_t chunks : {1u, 2u, 5u, 24u, 100u}) {
      std::size_t next = 0;
      for (std::size_t k = 0; k < chunks; ++k) {
        const auto [first, last] = points_of(k, chunks, points);
        EXPECT_EQ(first, next);
        EXPECT_LE(last - first, (points + chunks - 1) / chunks);
        next = last;
      }
      EXPECT_EQ(next, points);
    }
  const std::size_t most = std::numeric_limits<std::size_t>::max();
  const auto [first, last] = points_of(most - 1, most, 24);
  EXPECT_EQ(first, 24u);
  EXPECT_EQ(last, 24u);
}

TEST(Sweep, TheTableHoldsEveryMetricOfEveryPoint) {
  const SweepPoints points({{"n.a", {"1", "2", "3"}}}, {});
  const auto report = [](const char* status, double v) {
    return nlohmann::json{{"seconds", 1.5},
                          {"nodes", {{{"name", "n"}, {"status", status}, {"metrics", {{"phi, total", v}}}}}}};
  };
  SweepTable table(points);
  table.add(1, report("failed", 2));  // in any order
  table.add(0, report("computed", 0.25));
  std::string text;
  table.write([&](const std::string& row) { text += row; });
  EXPECT_EQ(text,
            "point,n.a,status,seconds,\"n.phi, total\"\n"
            "point-001,1,done,1.500,0.25\n"
            "point-002,2,failed,1.500,2\n"
            "point-003,3,not run,,\n");
}

}  // namespace
}  // namespace terrazzo

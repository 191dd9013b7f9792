#include <gtest/gtest.h>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

Value block(const Vec3i& low, const Vec3i& size) {
  initialize_openvdb();
  Volume v;
  v.grids.push_back(dense_grid<openvdb::FloatGrid>(
      "density", size, 0.1, Work(), [](std::size_t i) { return static_cast<float>(i % 5); }, low));
  return Value::of(v);
}

TEST(BlockIndex, ListsWhereTheBlocksLie) {
  // In any order; the second one is thinner.
  const std::multimap<std::string, Value> blocks = {{"volumes", block({8, 0, 0}, {3, 9, 8})},
                                                    {"volumes", block({0, 0, 0}, {8, 9, 8})}};
  const auto run = test::run_node("BlockIndex", blocks, {{"files", "part_{}.vdb"}});
  const auto table = run.output<Table>("table");
  using Row = std::vector<Table::Cell>;
  EXPECT_EQ(table.columns, (std::vector<std::string>{"block", "file", "x voxels", "y voxels", "z voxels",
                                                     "size x voxels", "size y voxels", "size z voxels"}));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[0], (Row{0.0, "part_0.vdb", 8.0, 0.0, 0.0, 3.0, 9.0, 8.0}));
  EXPECT_EQ(table.rows[1], (Row{1.0, "part_1.vdb", 0.0, 0.0, 0.0, 8.0, 9.0, 8.0}));
  EXPECT_EQ(run.metrics.at("voxels"), 11 * 9 * 8);
  EXPECT_EQ(test::run_node("BlockIndex", blocks).output<Table>("table").columns.size(), 7u);
}

TEST(BlockIndex, RefusesWhatIsNoWholeSolid) {
  const auto code = [](const std::multimap<std::string, Value>& blocks,
                       const std::map<std::string, std::string>& parameters = {}) {
    return test::code_of([&] { test::run_node("BlockIndex", blocks, parameters); });
  };
  const Value a = block({0, 0, 0}, {8, 8, 8});
  EXPECT_EQ(code({{"volumes", a}, {"volumes", a}}), "overlapping-blocks");
  EXPECT_EQ(code({{"volumes", a}, {"volumes", block({9, 0, 0}, {8, 8, 8})}}), "missing-blocks");
  EXPECT_EQ(code({{"volumes", block({8, 0, 0}, {8, 8, 8})}}), "missing-blocks");
  EXPECT_EQ(code({{"volumes", block({8, 0, 0}, {8, 8, 8})}}, {{"periodic", "false"}}), "");
  EXPECT_EQ(code({{"volumes", a}}, {{"files", "solid.vdb"}}), "bad-value");
}

}  // namespace
}  // namespace terrazzo

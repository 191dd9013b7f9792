#include "nodes/volumes/join_volumes/join_volumes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/data/image.h"
#include "nodes/data/volume.h"
#include "nodes/register_nodes.h"
#include "runtime/codec.h"
#include "runtime/random.h"
#include "tests/nodes/solids/solid_optimize/exemplars.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {

// Colors and numbers at the voxels from `low` to low + size − 1; large parts have one color.
Volume block(const Vec3i& low, const Vec3i& size, double voxel = 0.1) {
  initialize_openvdb();
  Volume v;
  const auto at = [&](std::size_t i) {
    const int n = static_cast<int>(i);
    return Vec3i(low + Vec3i(n % size.x(), n / size.x() % size.y(), n / size.x() / size.y()));
  };
  v.grids.push_back(dense_grid<openvdb::Vec3SGrid>(
      "Cd", size, voxel, Work(),
      [&](std::size_t i) {
        const Vec3i p = at(i);
        if (p.x() < 20) return openvdb::Vec3s(0.25f);
        const auto u = static_cast<float>(
            Random(1, static_cast<std::uint64_t>(p.x() + 100 * p.y()), static_cast<std::uint64_t>(p.z()))
                .uniform());
        return openvdb::Vec3s(u, 1 - u, u * u);
      },
      low));
  v.grids.push_back(dense_grid<openvdb::FloatGrid>(
      "density", size, voxel, Work(), [&](std::size_t i) { return static_cast<float>(at(i).z() % 3); }, low));
  return v;
}

struct Cut {
  Vec3i size;
  std::vector<int> planes[3];  // where blocks begin, then the size
  std::vector<Volume> blocks() const {
    std::vector<Volume> out;
    for (std::size_t k = 0; k + 1 < planes[2].size(); ++k)
      for (std::size_t j = 0; j + 1 < planes[1].size(); ++j)
        for (std::size_t i = 0; i + 1 < planes[0].size(); ++i)
          out.push_back(block(Vec3i(planes[0][i], planes[1][j], planes[2][k]),
                              Vec3i(planes[0][i + 1] - planes[0][i], planes[1][j + 1] - planes[1][j],
                                    planes[2][k + 1] - planes[2][k])));
    return out;
  }
};

Volume join(const std::vector<Volume>& blocks, const std::map<std::string, std::string>& parameters = {},
            int threads = 0) {
  std::multimap<std::string, Value> inputs;
  for (const Volume& b : blocks) inputs.emplace("volumes", Value::of<Volume>(b));
  return test::run_node("JoinVolumes", inputs, parameters, {}, threads).output<Volume>("volume");
}

std::string message_of(const std::vector<Volume>& blocks, const std::string& code) {
  try {
    join(blocks);
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, code);
    return e.diagnostic().message;
  }
  return "no error";
}

TEST(JoinVolumes, SixtyFourBlocksAreTheWholeInAnyOrder) {
  Volume whole = block(Vec3i::Zero(), Vec3i(40, 37, 64));
  whole.resolution = Vec3i(40, 37, 64);
  std::vector<Volume> blocks =
      Cut{{40, 37, 64}, {{0, 8, 16, 30, 40}, {0, 9, 18, 27, 37}, {0, 16, 32, 48, 64}}}.blocks();
  ASSERT_EQ(blocks.size(), 64u);
  Random random(3);
  for (const int threads : {1, 2, 7}) {
    std::shuffle(blocks.begin(), blocks.end(), random);
    EXPECT_TRUE(test::bytes_of(join(blocks, {}, threads)) == test::bytes_of(whole));
  }
  whole.resolution = Vec3i::Zero();
  whole.extent = Vec3i(40, 37, 64);
  EXPECT_TRUE(test::bytes_of(join(blocks, {{"periodic", "false"}})) == test::bytes_of(whole));
}

TEST(JoinVolumes, RandomCutsAreTheWhole) {
  for (std::uint64_t trial = 0; trial < 30; ++trial) {
    Random random(5, 0, trial);
    Cut cut;
    for (int a = 0; a < 3; ++a) {
      cut.planes[a] = {0};
      for (std::size_t n = 1 + random.below(4); n > 0; --n)
        cut.planes[a].push_back(cut.planes[a].back() + 1 + static_cast<int>(random.below(20)));
      cut.size[a] = cut.planes[a].back();
    }
    Volume whole = block(Vec3i::Zero(), cut.size);
    whole.resolution = cut.size;
    EXPECT_TRUE(test::bytes_of(join(cut.blocks())) == test::bytes_of(whole)) << trial;
  }
}

TEST(JoinVolumes, BlocksOfASolidTextureAreTheWhole) {
  const std::map<std::string, std::string> settings = {
      {"size", "[32, 32, 33]"}, {"levels", "2"}, {"iterations", "1"}, {"seed", "4"}};
  const Value exemplar = Value::of<Image>(test::blobs(32, 32, 8, 1));
  auto whole_settings = settings;
  whole_settings["method"] = "blockwise";
  const auto whole = test::run_node("SolidOptimize", {{"exemplar", exemplar}}, whole_settings);
  const auto base = test::run_node("SolidBase", {{"exemplar", exemplar}}, settings);
  std::vector<Volume> blocks;
  for (int k = 0; k < 8; ++k)
    blocks.push_back(test::run_node("SolidBlock", {{"base", base.outputs.at("base")}},
                                    {{"blocks", "2"}, {"block", std::to_string(k)}})
                         .output<Volume>("volume"));
  EXPECT_TRUE(test::bytes_of(join(blocks)) == test::bytes_of(whole.output<Volume>("volume")));
}

TEST(JoinVolumes, ReadsOneBlockAtATime) {
  Registry registry;
  register_nodes(registry);
  for (const char* node : {"JoinVolumes", "BlockIndex"})
    EXPECT_TRUE(registry.find(node)->find_input("volumes")->one_at_a_time) << node;
}

TEST(JoinVolumes, MissingBlocksAreNamed) {
  const Cut cut{{32, 32, 32}, {{0, 16, 32}, {0, 16, 32}, {0, 16, 32}}};
  auto blocks = cut.blocks();
  blocks.erase(blocks.begin() + 5);
  EXPECT_EQ(message_of(blocks, "missing-blocks"),
            "no block begins at voxel (16, 0, 16); 1 of 8 blocks are missing");
  EXPECT_EQ(message_of({block({0, 0, 0}, {8, 8, 8}), block({0, 0, 12}, {8, 8, 8})}, "missing-blocks"),
            "no block contains the voxels from 8 to 11 along z");
  EXPECT_EQ(message_of({block({0, 8, 0}, {8, 8, 8})}, "missing-blocks"),
            "the first block begins at voxel (0, 8, 0) instead of (0, 0, 0)");
}

TEST(JoinVolumes, OverlapsAreNamed) {
  const Volume a = block({0, 0, 0}, {8, 8, 8});
  EXPECT_EQ(message_of({a, a}, "overlapping-blocks"), "blocks 0 and 1 both begin at voxel (0, 0, 0)");
  EXPECT_EQ(message_of({a, block({0, 6, 0}, {8, 8, 8})}, "overlapping-blocks"),
            "blocks 0 and 1 overlap: along y, one ends at voxel 7 and the other begins at 6");
}

TEST(JoinVolumes, UnequalBlocksAreNamed) {
  const Volume a = block({0, 0, 0}, {8, 8, 8});
  EXPECT_EQ(message_of({a, block({8, 0, 0}, {8, 9, 8})}, "unequal-blocks"),
            "block 1 has 9 voxels along y, but block 0, which begins at the same y, has 8");
  EXPECT_EQ(message_of({a, block({8, 0, 0}, {8, 8, 8}, 0.2)}, "unequal-blocks"),
            "grid 'Cd' of block 1 differs in transform from that of block 0");
  Volume less = block({8, 0, 0}, {8, 8, 8});
  less.grids.pop_back();
  EXPECT_EQ(message_of({a, less}, "unequal-blocks"),
            "grid 1 of block 1 is 'none', but that of block 0 is 'density'");
  Volume typed = block({8, 0, 0}, {8, 8, 8});
  typed.grids[1] = dense_grid<openvdb::Int32Grid>("density", {8, 8, 8}, 0.1, Work(),
                                                  [](std::size_t) { return 1; }, {8, 0, 0});
  EXPECT_EQ(message_of({a, typed}, "unequal-blocks"),
            "grid 'density' of block 1 differs in type from that of block 0");
  Volume sparse = block({8, 0, 0}, {8, 8, 8});
  const auto hole = sparse.find<openvdb::FloatGrid>("density")->deepCopy();
  hole->tree().setValueOff(openvdb::Coord(9, 1, 1));
  sparse.grids[1] = hole;
  EXPECT_EQ(message_of({a, sparse}, "not-a-block"),
            "grid 'density' of block 1 does not fill a box: 511 voxels have a value");
  Volume whole = block({8, 0, 0}, {8, 8, 8});
  whole.resolution = Vec3i::Constant(8);
  EXPECT_EQ(message_of({a, whole}, "not-a-block"), "block 1 is a whole solid that tiles");
}

}  // namespace
}  // namespace terrazzo

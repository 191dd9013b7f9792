// Blocks made separately, compared with the same solid made as a whole.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <string>

#include "nodes/data/volume.h"
#include "nodes/solids/synthesis/blockwise/blocks.h"
#include "nodes/solids/synthesis/matching/weights.h"
#include "nodes/solids/synthesis/optimize_solid.h"
#include "tests/nodes/solids/solid_optimize/exemplars.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace so = solids;

// Three levels, of which only the coarsest is made whole. Statistics of the others are measured on a corner.
so::SolidOptions settings_of(const Vec3i& size) {
  so::SolidOptions s;
  s.size = size;
  s.levels = 3;
  s.iterations = {2};
  s.method = so::SolidMethod::Blockwise;
  s.finish = 1;
  s.blockwise_limits.whole = 1;
  s.blockwise_limits.probe = 20;
  s.blockwise_limits.closed = 24;
  return s;
}

const so::SolidExemplar& exemplar() {
  static const so::SolidExemplar e = test::exemplar_of(test::blobs(64, 64, 8, 1));
  return e;
}

// Number of the block's voxels that differ from the whole solid's.
std::size_t different(const so::SolidResult& whole, const so::SolidResult& block) {
  std::size_t count = 0;
  const auto at = [](const so::SolidField& f, std::size_t c, const Vec3i& v) {
    return f.channel[c][(static_cast<std::size_t>(v.z()) * f.size.y() + v.y()) * f.size.x() + v.x()];
  };
  for (int z = 0; z < block.size.z(); ++z)
    for (int y = 0; y < block.size.y(); ++y)
      for (int x = 0; x < block.size.x(); ++x)
        for (std::size_t c = 0; c < whole.field.channel.size(); ++c)
          count += at(block.field, c, Vec3i(x, y, z)) != at(whole.field, c, block.origin + Vec3i(x, y, z));
  return count;
}

void expect_blocks_are_the_whole(const Vec3i& blocks, so::SolidOptions s) {
  const Vec3i size = s.size;
  const so::SolidResult whole = so::optimize_solid({exemplar()}, s, Work());
  ASSERT_EQ(whole.size, size);
  const so::BlockBase base = so::solid_base({exemplar()}, s, Work());
  s.blocks = blocks;
  std::vector<int> order(static_cast<std::size_t>(blocks.prod()));
  std::iota(order.begin(), order.end(), 0);
  Random random(7);
  std::shuffle(order.begin(), order.end(), random);
  std::size_t covered = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    s.block = order[i];
    so::SolidResult block;
    tbb::task_arena arena(std::array{1, 2, 7}[i % 3]);
    arena.execute([&] { block = so::solid_block({exemplar()}, s, base, Work()); });
    EXPECT_EQ(different(whole, block), 0u) << "block " << s.block;
    covered += block.field.channel[0].size();
  }
  EXPECT_EQ(covered, whole.field.channel[0].size());
}

TEST(SolidBlocks, AreTheWholeInAnyOrderOnAnyNumberOfThreads) {
  expect_blocks_are_the_whole(Vec3i(2, 2, 2), settings_of(Vec3i(36, 36, 36)));
}
TEST(SolidBlocks, AreTheWholeWhereSizesAreOdd) {
  expect_blocks_are_the_whole(Vec3i(2, 1, 2), settings_of(Vec3i(41, 33, 51)));
}
TEST(SolidBlocks, AreTheWholeWhereTheyAreMuchSmallerThanWhatTheyNeed) {
  expect_blocks_are_the_whole(Vec3i(1, 1, 3), settings_of(Vec3i(32, 34, 32)));
}

// Levels above one with random matches and colors: any whole level will do for comparing parts.
struct Levels {
  so::SolidOptions s;
  std::vector<so::SolidExemplar> working{exemplar()};
  std::vector<so::Pyramid> pyramids;
  std::vector<int> iterations;
  so::WholeLevel coarse;
  std::unique_ptr<so::BlockLevels> made;
  static constexpr int kChannels = 3;

  explicit Levels(const so::SolidOptions& settings) : s(settings), iterations(so::iterations_of(s, 3)) {
    pyramids.push_back(so::exemplar_levels(working[0], kChannels, 0, 3, 0.98, 32, 16, Work()));
    for (auto& level : pyramids[0]) so::find_similar(level, Work());
    const Vec3i size = coarse.field.size = so::box_at(s.size, 0, 3);
    for (int c = 0; c < kChannels; ++c) {
      std::vector<float> v(so::voxels(size));
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = static_cast<float>(Random(3, 1, i).uniform());
      coarse.field.channel.push_back(v);
    }
    for (int a = 0; a < 3; ++a) coarse.families.push_back(so::random_matches(size, a, 0, pyramids[0][0], 1));
    made = std::make_unique<so::BlockLevels>(working, pyramids, s, iterations, kChannels, coarse);
  }
  so::TorusBox closed() const {
    so::TorusBox box;
    box.hi = s.size;
    box.closed = {true, true, true};
    return box;
  }
};

TEST(SolidBlocks, ATorusHasNoEdge) {
  const Levels all(settings_of(Vec3i(45, 40, 34)));
  so::BlockLevels& levels = *all.made;
  const so::SolidOptions& s = all.s;
  EXPECT_FALSE(levels.measure(nullptr, Work()));  // the probe is a corner
  so::TorusBox across;
  across.lo = Vec3i(-6, 33, -9);
  across.hi = Vec3i(7, 47, 5);
  const auto one = levels.make(all.closed(), nullptr, Work()), other = levels.make(across, nullptr, Work());
  std::size_t count = 0;
  for (int z = across.lo.z(); z < across.hi.z(); ++z)
    for (int y = across.lo.y(); y < across.hi.y(); ++y)
      for (int x = across.lo.x(); x < across.hi.x(); ++x) {
        so::TorusBox a, b;
        a.lo = Vec3i(x, y, z);
        a.hi = a.lo + Vec3i::Ones();
        for (int k = 0; k < 3; ++k) b.lo[k] = so::wrapped(a.lo[k], s.size[k]);
        b.hi = b.lo + Vec3i::Ones();
        for (int c = 0; c < Levels::kChannels; ++c)
          ASSERT_EQ(so::values_in(a, other, c), so::values_in(b, one, c)) << a.lo.transpose();
        ++count;
      }
  EXPECT_EQ(count, 13u * 14 * 14);
}

TEST(SolidBlocks, WhereTheProbeIsEverythingTheSolidIsMadeWithIt) {
  so::SolidOptions s = settings_of(Vec3i(40, 33, 36));
  s.blockwise_limits.closed = 40;
  s.sources = true;
  const so::SolidResult whole = so::optimize_solid({exemplar()}, s, Work());
  EXPECT_EQ(whole.field.channel[0].size(), 40u * 33 * 36);
  EXPECT_EQ(whole.sources.texel.size(), 40u * 33 * 36);
  expect_blocks_are_the_whole(Vec3i(2, 1, 3), s);
  // Made again with the statistics that were measured along the way.
  const Levels all(s);
  const auto made = all.made->measure(nullptr, Work());
  ASSERT_TRUE(made);
  const auto again = all.made->make(all.closed(), nullptr, Work());
  for (int c = 0; c < Levels::kChannels; ++c)
    EXPECT_EQ(so::values_in(all.closed(), *made, c), so::values_in(all.closed(), again, c)) << c;
}

TEST(SolidBlocks, LookLikeTheExemplarAsTheWholeMethodsDo) {
  so::SolidOptions s;
  s.size = Vec3i::Constant(56);
  s.iterations = {8, 4};
  const auto sweeps = so::optimize_solid({exemplar()}, s, Work());
  s.method = so::SolidMethod::Blockwise, s.finish = 1, s.blockwise_limits.probe = 32,
  s.blockwise_limits.closed = 16;
  const auto local = so::optimize_solid({exemplar()}, s, Work());
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_LT(local.measures[a].patches, 1.5 * sweeps.measures[a].patches + 0.01) << a;
    EXPECT_LT(local.measures[a].histogram, 0.06) << a;
    EXPECT_NEAR(local.measures[a].bands[0], 1, 0.3) << a;  // blobs have almost none
    EXPECT_LT(local.measures[a].copied_worst, 0.8) << a;
    EXPECT_LT(local.measures[a].stripes_worst, 3) << a;
  }
}

TEST(SolidBlocks, NeedNoMoreMemoryThanForecast) {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "sanitizers keep memory of their own for every byte";
#endif
  so::SolidOptions s = settings_of(Vec3i::Constant(192));
  s.iterations = {1};
  s.blockwise_iterations = 1;
  so::BlockBase base;
  const auto fits = [](double used, double forecast) {
    EXPECT_LT(used, 1.1 * forecast + 8e6);  // threads and tables that do not grow with the solid
    EXPECT_GT(used, 0.5 * forecast);
  };
  const double of_base = test::peak_of([&] { base = so::solid_base({exemplar()}, s, Work()); });
  if (of_base < 0) GTEST_SKIP() << "peak memory is not available here";
  fits(of_base, so::base_forecast({exemplar()}, s));
  s.blocks = Vec3i(2, 2, 2);
  s.block = 5;
  so::SolidResult r;
  const double of_block = test::peak_of([&] { r = so::solid_block({exemplar()}, s, base, Work()); }),
               forecast = so::block_forecast({exemplar()}, s);
  if (of_block >= 0) fits(of_block, forecast);
  // A block needs the same memory in a solid of any size, except for the matches of its coarsest level.
  so::SolidOptions large = s;
  large.size = Vec3i::Constant(384);
  large.blocks = Vec3i::Constant(4);
  large.block = 21;
  EXPECT_LT(so::block_forecast({exemplar()}, large), 1.5 * forecast);
  large.blocks = Vec3i::Ones();
  large.block = 0;
  EXPECT_GT(so::memory_forecast({exemplar()}, large), 4 * forecast);
}

TEST(SolidBlocks, StopWhenCancelled) {
  so::SolidOptions s = settings_of(Vec3i::Constant(40));
  const so::BlockBase base = so::solid_base({exemplar()}, s, Work());
  s.blocks = Vec3i(2, 1, 1);
  for (const double stop : {0.2, 0.4, 0.6, 0.9}) {
    std::atomic<bool> cancel{false};
    const Work::Report report = [&](double fraction, const std::string&) { cancel = fraction >= stop; };
    EXPECT_THROW(so::solid_base({exemplar()}, s, Work(&cancel, &report)), Cancelled) << stop;
    cancel = false;
    EXPECT_THROW(so::solid_block({exemplar()}, s, base, Work(&cancel, &report)), Cancelled) << stop;
  }
}

using Parameters = std::map<std::string, std::string>;
using Inputs = std::multimap<std::string, Value>;

Inputs pictures() {
  return {{"exemplar", Value::of<Image>(test::blobs(64, 64, 8, 1))},
          {"features", Value::of<Image>(test::blobs(64, 64, 5, 2))}};
}

test::NodeRun base_of(Parameters p = {}) {
  p.try_emplace("size", "40");
  p.try_emplace("iterations", "[4, 2]");
  return test::run_node("SolidBase", pictures(), p);
}

TEST(SolidBlocks, LieAtTheirPlaceInTheWhole) {
  const auto whole = test::run_node(
      "SolidOptimize", pictures(),
      {{"size", "40"}, {"iterations", "[4, 2]"}, {"method", "blockwise"}, {"sources", "true"}});
  const auto block = test::run_node("SolidBlock", {{"base", base_of().outputs.at("base")}},
                                    {{"sources", "true"}, {"blocks", "[2, 1, 2]"}, {"block", "3"}});
  EXPECT_EQ(whole.metrics.count("seam_ratio"), 1u);
  EXPECT_EQ(block.metrics.count("seam_ratio"), 0u);  // a block has no wrap
  const auto& volume = block.output<Volume>("volume");
  EXPECT_EQ(volume.resolution, Vec3i::Zero());
  EXPECT_EQ(whole.output<Volume>("volume").resolution, Vec3i::Constant(40));
  const auto same = [&]<class Grid>(const char* name, const Grid*) {
    const auto a = volume.find<Grid>(name), b = whole.output<Volume>("volume").find<Grid>(name);
    ASSERT_TRUE(a && b) << name;
    EXPECT_EQ(a->evalActiveVoxelBoundingBox(),
              openvdb::CoordBBox(openvdb::Coord(20, 0, 20), openvdb::Coord(39, 39, 39)));
    EXPECT_EQ(a->activeVoxelCount(), 20u * 40 * 20);
    EXPECT_TRUE(a->transform() == b->transform());
    for (auto it = a->cbeginValueOn(); it; ++it)
      ASSERT_EQ(*it, b->tree().getValue(it.getCoord())) << name << it.getCoord();
  };
  same("Cd", static_cast<openvdb::Vec3SGrid*>(nullptr));
  same("features", static_cast<openvdb::Vec3SGrid*>(nullptr));
  same("source", static_cast<openvdb::Vec3IGrid*>(nullptr));
}

TEST(SolidBlocks, SayWhatIsWrong) {
  const auto wrong = [](const std::function<void()>& go) {
    try {
      go();
    } catch (const Error& e) {
      return e.diagnostic().code + " " + e.diagnostic().parameter;
    }
    return std::string("none");
  };
  const Value base = base_of().outputs.at("base");
  const auto block = [&](const Parameters& p) {
    return wrong([&] { test::run_node("SolidBlock", {{"base", base}}, p); });
  };
  EXPECT_EQ(block({{"blocks", "2"}, {"block", "8"}}), "bad-value block");
  EXPECT_EQ(block({{"block", "1"}}), "bad-value block");
  EXPECT_EQ(block({{"blocks", "4"}}), "bad-value blocks");
  EXPECT_EQ(block({{"blocks", "[2, 2]"}}), "bad-value blocks");
  EXPECT_EQ(block({{"memory", "1"}}), "too-large blocks");
  EXPECT_EQ(wrong([] { base_of({{"levels", "1"}}); }), "bad-value levels");
  EXPECT_EQ(wrong([] { base_of({{"size", "4096"}, {"memory", "100"}}); }), "too-large size");
}

TEST(SolidBlocks, ExemplarsLeaveTheFinishSomethingToMeasure) {
  so::SolidOptions s = settings_of(Vec3i::Constant(32));
  s.levels = 2;
  try {
    so::optimize_solid({test::exemplar_of(test::blobs(23, 40, 8, 1))}, s, Work());
    ADD_FAILURE() << "23 pixels were accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "exemplar-too-small");
  }
  EXPECT_EQ(so::optimize_solid({test::exemplar_of(test::blobs(24, 40, 8, 1))}, s, Work()).size, s.size);
}

TEST(SolidBlocks, PatchesAreNumberedAroundTheTorus) {
  for (const int period : {16, 17, 33})
    for (int q = -40; q < 40; ++q) {
      EXPECT_LT(so::patch_start(q, period), so::patch_start(q + 1, period));
      EXPECT_EQ(so::first_patch(so::patch_start(q, period), period), q);
      EXPECT_EQ(so::first_patch(so::patch_start(q, period) + 1, period), q + 1);
      EXPECT_EQ(so::patch_start(q + so::patches_around(period), period), so::patch_start(q, period) + period);
    }
  EXPECT_EQ(so::patch_start(9, 17), 17);
  EXPECT_EQ(so::patch_start(-1, 17), -1);
}

TEST(SolidBlocks, WeightsAreThePowers) {
  for (const double power : {-1.0, -0.6, 0.0}) {
    const so::WeightTable table(power);
    for (const double x : {0.0, 1e-6, 0.3, 1.0, 7.7, 1234.5, 1e6})
      EXPECT_NEAR(table.of(static_cast<float>(x)) / std::pow(1 + x, power), 1, 2e-5) << x;
    EXPECT_GE(table.of(1e30f), 0);
  }
}

TEST(SolidBlocks, FinestBandsOfAPictureAreItsDetails) {
  so::SolidExemplar e;
  e.width = e.height = 32;
  for (int i = 0; i < 32 * 32; ++i)
    e.pixels.push_back(Vec3f(i / 32 % 2 ? 1.0f : -1.0f, i % 2 ? 1.0f : -1.0f, static_cast<float>(i % 32)));
  const auto bands = so::finest_bands(e, 3);
  ASSERT_EQ(bands[0].size(), 4u);
  for (std::size_t b = 0; b < 4; ++b) {
    EXPECT_NEAR(bands[0][b].deviation, b == 1, 1e-6)
        << b;  // every other row: the variance is all along columns
    EXPECT_NEAR(bands[1][b].deviation, b == 0, 1e-6)
        << b;                                          // every other column: the variance is all along rows
    EXPECT_NEAR(bands[2][b].deviation, 0, 1e-5) << b;  // a ramp has none
  }
}

}  // namespace
}  // namespace terrazzo

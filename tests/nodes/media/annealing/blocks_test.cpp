// Solids of phases made in blocks, and the base that these share.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/data/indices.h"
#include "nodes/data/volume.h"
#include "nodes/media/annealing/block.h"
#include "nodes/media/annealing/media_base.h"
#include "runtime/codec.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace annealing;
using media::PhaseMap;

PhaseMap discs(int phases) {
  PhaseMap map{96, 96, phases, 0.5, std::vector<std::uint8_t>(96 * 96, 0)};
  for (int k = 0; k < 60; ++k) {
    Random r(6, 9, k);
    const double cx = r.uniform(0, 96), cy = r.uniform(0, 96);
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 96; ++x)
        if (std::hypot(x - cx, y - cy) < 4.3)
          map.at[map.index(x, y)] = static_cast<std::uint8_t>(1 + k % (phases - 1));
  }
  return map;
}

AnnealOptions of_size(const Vec3i& size) {
  AnnealOptions out;
  out.size = size;
  return out;
}

TEST(MediaBlocks, OneIsTheSolid) {
  for (const int phases : {2, 3}) {
    const std::vector<PhaseMap> pictures = {discs(phases)};
    const AnnealOptions options = of_size({40, 48, 36});
    const auto coarse = synthesize_coarse(pictures, options, {});
    EXPECT_EQ(synthesize_block(pictures, options, coarse, 1, 0, {}).phase,
              synthesize(pictures, options, {}).phase);
  }
}

// Neighbors make the same seams, the last block and the first too, and each block has the pictures'
// fractions.
TEST(MediaBlocks, FitTogether) {
  for (const int phases : {2, 3}) {
    const std::vector<PhaseMap> pictures = {discs(phases)};
    const Vec3i size(24, 28, 2 * 98 + 1);
    const AnnealOptions options = of_size(size);
    const auto coarse = synthesize_coarse(pictures, options, {});
    const auto shares = fractions_of(pictures[0]);
    std::vector<Slab> made;
    for (int k = 0; k < 2; ++k) {
      Descent descent(pictures, options);
      Block block(descent, coarse, 2, k, options.seed);
      for (const int stride : {2, 1}) block.refine(stride, {});
      made.push_back(block.slab());
      const Layers own = layers_of(2, k, size.z());
      const auto phase = part_of(block.slab(), own).phase;
      EXPECT_EQ(phase, synthesize_block(pictures, options, coarse, 2, k, {}).phase);
      for (int p = 0; p < phases; ++p)
        EXPECT_NEAR(std::count(phase.begin(), phase.end(), p), shares[p] * phase.size(), 1);
    }
    for (int k = 0; k < 2; ++k) {
      const Layers own = layers_of(2, k, size.z());
      const int cut = own.first + own.count, other = k == 1 ? cut - size.z() : cut;
      EXPECT_EQ(part_of(made[k], {cut - Block::kSeam, 2 * Block::kSeam}).phase,
                part_of(made[1 - k], {other - Block::kSeam, 2 * Block::kSeam}).phase)
          << k;
    }
  }
}

// The counts that sweeps update are those of the field that they leave, whatever lies at its ends.
TEST(MediaBlocks, EndsCountAsTheyShould) {
  for (const int phases : {2, 3}) {
    const PhaseMap map = discs(phases);
    const Vec3i size(17, 12, 40);
    std::vector<PatternTarget> targets;
    for (const int spacing : {1, 2, 4})
      for (int axis = 0; axis < 3; ++axis) {
        targets.push_back({axis, spacing, {}});
        for (int p = 0; p < phases; ++p)
          targets.back().phase.push_back(pattern_frequencies(map, p, spacing, true));
      }
    std::vector<std::uint8_t> noise(voxels_in(size));
    for (std::size_t i = 0; i < noise.size(); ++i)
      noise[i] = static_cast<std::uint8_t>(Random(3, 1, i).below(phases));
    for (const Ends ends : {Ends::Open, Ends::Frozen}) {
      Level level(noise, size, phases, targets, 1e-3, ends, {});
      const double before = level.mismatch();
      for (int s = 0; s < 5; ++s) EXPECT_GT(level.sweep(s, 0, {}), 0u);
      const double after = level.mismatch();
      EXPECT_LT(after, 0.7 * before);
      const auto field = level.take();
      EXPECT_NEAR(Level(field, size, phases, targets, 1e-3, ends, {}).mismatch(), after, 1e-9 * before);
      if (ends == Ends::Open) continue;
      const std::size_t slice = pixels_in(size.x(), size.y()), frozen = Level::kFrozen * slice;
      EXPECT_TRUE(std::equal(noise.begin(), noise.begin() + frozen, field.begin()));
      EXPECT_TRUE(std::equal(noise.end() - frozen, noise.end(), field.end() - frozen));
    }
  }
}

const test::NodeRun& base() {
  static const auto run =
      test::run_node("MediaBase", {{"labels", Value::of(labels_of(discs(2)))}}, {{"size", "[24, 32, 200]"}});
  return run;
}

TEST(MediaBlocks, LieWhereTheySay) {
  const Value shared = Value::of(base().output<MediaBase>("base"));
  const auto make = [&](const std::map<std::string, std::string>& parameters) {
    return test::run_node("MediaBlock", {{"base", shared}}, parameters);
  };
  const auto run = make({{"blocks", "2"}, {"block", "1"}});
  const Volume& volume = run.output<Volume>("volume");
  EXPECT_EQ(volume.first, Vec3i(0, 0, 100));
  EXPECT_EQ(volume.extent, Vec3i(24, 32, 100));
  const auto box = volume.grids.at(0)->evalActiveVoxelBoundingBox();
  EXPECT_EQ(box, openvdb::CoordBBox(0, 0, 100, 23, 31, 199));
  EXPECT_EQ(make({}).output<Volume>("volume").resolution, Vec3i(24, 32, 200));
  EXPECT_EQ(test::code_of([&] { make({{"blocks", "3"}}); }), "bad-value");
  EXPECT_EQ(test::code_of([&] { make({{"blocks", "2"}, {"block", "2"}}); }), "bad-value");
}

std::vector<char> stored() {
  BufferWriter w;
  value_type<MediaBase>().encode(&base().output<MediaBase>("base"), w);
  return w.buffer;
}

// Whether the bytes could be read. If they are rejected, the error code must be "damaged".
bool is_read(const std::vector<char>& bytes) {
  try {
    Reader r(bytes.data(), bytes.size());
    value_type<MediaBase>().decode(r);
    return true;
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "damaged");
    return false;
  }
}

TEST(MediaBase, ComesBackFromItsBytes) {
  const auto bytes = stored();
  Reader r(bytes.data(), bytes.size());
  const auto back = std::static_pointer_cast<const MediaBase>(value_type<MediaBase>().decode(r));
  EXPECT_EQ(r.left(), 0u);
  EXPECT_EQ(back->coarse.size, Vec3i(6, 8, 50));
  BufferWriter again;
  value_type<MediaBase>().encode(back.get(), again);
  EXPECT_EQ(again.buffer, bytes);
}

TEST(MediaBase, DamagedItIsRefusedOrRead) {
  const auto whole = stored();
  std::size_t refused = 0;
  for (std::size_t k = 0; k < 2000; ++k) {
    std::vector<char> bytes = whole;
    Random random(2, 0, k);
    bytes[random.below(bytes.size())] = static_cast<char>(random.bits());
    refused += !is_read(bytes);
    bytes.resize(random.below(bytes.size()));
    EXPECT_FALSE(is_read(bytes)) << bytes.size();
  }
  EXPECT_GT(refused, 100u);
}

}  // namespace
}  // namespace terrazzo

#include "nodes/data/volume.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "runtime/random.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {

std::shared_ptr<const Volume> decoded(const std::vector<char>& bytes) {
  Reader r(bytes.data(), bytes.size());
  return std::static_pointer_cast<const Volume>(value_type<Volume>().decode(r));
}

template <class Grid>
typename Grid::Ptr grid_of(const std::string& name, typename Grid::ValueType background) {
  initialize_openvdb();
  auto g = Grid::create(background);
  g->setName(name);
  g->setTransform(voxel_transform(0.1));
  return g;
}

// One grid of every type, with scattered voxels, dense blocks, tiles and negative coordinates.
Volume sample(int voxels = 300) {
  Volume v;
  v.resolution = Vec3i(32, 20, 16);
  auto density = grid_of<openvdb::FloatGrid>("density", 0);
  auto color = grid_of<openvdb::Vec3SGrid>("Cd", openvdb::Vec3s(0.5f, 0.25f, 0.125f));
  auto id = grid_of<openvdb::Int32Grid>("id", -1);
  auto mask = grid_of<openvdb::BoolGrid>("mask", false);
  auto depth = grid_of<openvdb::DoubleGrid>("depth", 3);
  Random r(1);
  for (int n = 0; n < voxels; ++n) {
    const openvdb::Coord at(static_cast<int>(r.below(64)) - 32, static_cast<int>(r.below(64)),
                            static_cast<int>(r.below(9000)));
    density->tree().setValueOn(at, static_cast<float>(r.uniform()));
    color->tree().setValueOn(at, openvdb::Vec3s(static_cast<float>(r.uniform()), 0, 1));
    id->tree().setValueOn(at, static_cast<int>(r.below(7)));
    mask->tree().setValueOn(at, r.uniform() < 0.5);
    depth->tree().setValueOff(at, r.uniform());
  }
  density->fill(openvdb::CoordBBox({0, 0, 0}, {40, 40, 40}), 1.0f);
  density->setGridClass(openvdb::GRID_FOG_VOLUME);
  color->insertMeta("provenance", openvdb::StringMetadata("{\"graph\": \"a.yaml\"}"));
  depth->setTransform(openvdb::math::Transform::createLinearTransform(
      openvdb::math::Mat4d(0.1, 0.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.7, 0.0, 1.0, 2.0, 3.0, 1.0)));
  v.grids = {density, color, id, mask, depth};
  return v;
}

TEST(Volume, ComesBackWhole) {
  const Volume v = sample();
  const auto bytes = test::bytes_of(v);
  const auto back = decoded(bytes);
  ASSERT_EQ(back->grids.size(), v.grids.size());
  EXPECT_EQ(back->resolution, v.resolution);
  EXPECT_EQ(test::bytes_of(*back), bytes);
  const auto a = v.find<openvdb::FloatGrid>("density"), b = back->find<openvdb::FloatGrid>("density");
  EXPECT_EQ(a->activeVoxelCount(), b->activeVoxelCount());
  for (auto it = a->cbeginValueOn(); it; ++it) ASSERT_EQ(b->tree().getValue(it.getCoord()), *it);
  EXPECT_EQ(b->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_EQ(back->grids[1]->metaValue<std::string>("provenance"), "{\"graph\": \"a.yaml\"}");
  EXPECT_EQ(back->grids[0]->transform(), v.grids[0]->transform());
  EXPECT_EQ(back->find<openvdb::DoubleGrid>("depth")->tree().background(), 3);
}

TEST(Volume, EqualVoxelsGiveEqualBytesWhateverTheTree) {
  Volume a, b;
  auto fill = grid_of<openvdb::FloatGrid>("density", 0), by_voxel = grid_of<openvdb::FloatGrid>("density", 0);
  fill->sparseFill(openvdb::CoordBBox({0, 0, 0}, {15, 15, 15}), 1.0f);
  for (int i = 15; i >= 0; --i)
    for (int j = 0; j < 16; ++j)
      for (int k = 0; k < 16; ++k) by_voxel->tree().setValueOn({i, j, k}, 1.0f);
  by_voxel->tree().touchLeaf({5000, 0, 0});  // a leaf with only background values
  a.grids = {fill}, b.grids = {by_voxel};
  EXPECT_EQ(test::bytes_of(a), test::bytes_of(b));
  by_voxel->tree().setValueOff({3, 3, 3});  // the value remains, the state changes
  EXPECT_NE(test::bytes_of(a), test::bytes_of(b));
}

TEST(Volume, DamagedBytesAreAnErrorOrAnotherVolume) {
  const auto whole = test::bytes_of(sample(20));
  std::size_t refused = 0;
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    auto bytes = whole;
    Random r(3, 0, trial);
    if (trial % 4 == 0) {
      bytes.resize(r.below(bytes.size()));
    } else {
      // Half of the trials damage the headers, which contain lengths and types.
      const std::size_t range = trial % 2 ? bytes.size() : 400;
      for (int n = 0; n < 3; ++n) bytes[r.below(range)] = static_cast<char>(r.bits());
    }
    try {
      decoded(bytes);
    } catch (const Error& e) {
      EXPECT_EQ(e.diagnostic().code, "damaged");
      ++refused;
    }
  }
  EXPECT_GE(refused, 50u);  // at least all truncated ones
}

TEST(Volume, IsDescribed) {
  Volume v;
  auto color = grid_of<openvdb::Vec3SGrid>("Cd", openvdb::Vec3s(0.0f));
  color->tree().setValueOn({1, 2, 3}, openvdb::Vec3s(0.5f, -1, 2));
  color->tree().setValueOn({4, 2, 0}, openvdb::Vec3s(0.25f, 1, 2));
  v.grids = {color, grid_of<openvdb::FloatGrid>("density", 0)};
  const auto grids = value_type<Volume>().describe(&v)["grids"];
  EXPECT_EQ(grids[0]["name"], "Cd");
  EXPECT_EQ(grids[0]["type"], "vec3s");
  EXPECT_EQ(grids[0]["active_voxels"], 2);
  EXPECT_EQ(grids[0]["min"], nlohmann::json({0.25, -1, 2}));
  EXPECT_EQ(grids[0]["max"], nlohmann::json({0.5, 1, 2}));
  EXPECT_EQ(grids[0]["voxel_size"], nlohmann::json({0.1, 0.1, 0.1}));
  EXPECT_EQ(grids[0]["bounding_box"], nlohmann::json({{1, 2, 0}, {4, 2, 3}}));
  EXPECT_TRUE(grids[1]["min"].is_null());
  EXPECT_TRUE(grids[1]["bounding_box"].is_null());
}

TEST(Volume, UnknownGridsAreRefused) {
  Volume v;
  v.grids = {grid_of<openvdb::Vec3DGrid>("velocity", openvdb::Vec3d(0.0))};
  BufferWriter w;
  try {
    value_type<Volume>().encode(&v, w);
    FAIL() << "encoded a vec3d grid";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "unsupported-grid");
  }
}

}  // namespace
}  // namespace terrazzo

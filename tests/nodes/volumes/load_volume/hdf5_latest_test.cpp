// HDF5 files of the newer form, written by the library itself with its bounds set to the latest version.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include "nodes/common/io/hdf5/hdf5_input.h"
#include "nodes/data/volume.h"
#include "runtime/files.h"
#include "tests/nodes/volumes/load_volume/load.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

struct LatestArray {
  std::vector<hsize_t> size = {4, 5, 6}, chunk, most;  // z, y, x
  bool packed = false, checked = false;
};

// Writes a DREAM3D file whose arrays have the number n + i of the array at element i.
void write_latest(const fs::path& path, const LatestArray& a, int arrays = 1, int attributes = 0) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  const hid_t parents = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(parents, 1);
  const std::string geometry = "/DataContainers/Image/_SIMPL_GEOMETRY";
  const hsize_t three = 3;
  const hid_t space_3 = H5Screate_simple(1, &three, nullptr);
  const auto put = [&](const char* name, hid_t type, const void* data) {
    const hid_t set =
        H5Dcreate2(file, (geometry + "/" + name).c_str(), type, space_3, parents, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
    H5Dclose(set);
  };
  const std::uint64_t size[] = {a.size[2], a.size[1], a.size[0]};
  const float spacing[] = {500, 500, 500};
  put("DIMENSIONS", H5T_NATIVE_UINT64, size);
  put("SPACING", H5T_NATIVE_FLOAT, spacing);
  const hid_t group = H5Gopen2(file, geometry.c_str(), H5P_DEFAULT);
  for (int k = 0; k < attributes; ++k) {
    const std::string name = k + 1 < attributes ? fmt::format("attribute {}", k) : "Period";
    const hid_t attribute =
        H5Acreate2(group, name.c_str(), H5T_NATIVE_UINT64, space_3, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_UINT64, size);
    H5Aclose(attribute);
  }
  H5Gclose(group);
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  if (!a.chunk.empty()) H5Pset_chunk(creation, 3, a.chunk.data());
  if (a.packed) {
    H5Pset_shuffle(creation);
    H5Pset_deflate(creation, 6);
  }
  if (a.checked) H5Pset_fletcher32(creation);
  const hid_t space = H5Screate_simple(3, a.size.data(), a.most.empty() ? nullptr : a.most.data());
  for (int n = 0; n < arrays; ++n) {
    std::vector<std::int32_t> values;
    for (hsize_t i = 0; i < a.size[0] * a.size[1] * a.size[2]; ++i)
      values.push_back(static_cast<std::int32_t>(i) + n);
    const hid_t set = H5Dcreate2(file, fmt::format("/DataContainers/Image/CellData/array {:03}", n).c_str(),
                                 H5T_NATIVE_INT32, space, parents, creation, H5P_DEFAULT);
    H5Dwrite(set, H5T_NATIVE_INT32, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(set);
  }
  H5Sclose(space);
  H5Pclose(creation);
  H5Sclose(space_3);
  H5Pclose(parents);
  H5Pclose(access);
  H5Fclose(file);
}

void expect_counting(const fs::path& path, const LatestArray& a, const char* what, int arrays = 1) {
  const auto run = test::load_volume(path);
  const auto& volume = run.output<Volume>("volume");
  ASSERT_EQ(volume.grids.size(), static_cast<std::size_t>(arrays)) << what;
  for (int n = 0; n < arrays; ++n) {
    const auto grid = volume.find<openvdb::Int32Grid>(fmt::format("array {:03}", n));
    ASSERT_TRUE(grid) << what << n;
    int i = n;
    for (int z = 0; z < static_cast<int>(a.size[0]); ++z)
      for (int y = 0; y < static_cast<int>(a.size[1]); ++y)
        for (int x = 0; x < static_cast<int>(a.size[2]); ++x)
          ASSERT_EQ(grid->tree().getValue(openvdb::Coord(x, y, z)), i++) << what;
  }
}

TEST(LatestHdf5, EveryIndexOfChunksIsRead) {
  const auto folder = test::temporary_folder();
  constexpr hsize_t kAny = H5S_UNLIMITED;
  const std::pair<const char*, LatestArray> cases[] = {
      {"together", {}},
      {"a single chunk", {.chunk = {4, 5, 6}}},
      {"a single chunk, compressed", {.chunk = {4, 5, 6}, .packed = true}},
      {"a fixed array", {.chunk = {2, 3, 4}}},
      {"a fixed array, compressed", {.chunk = {2, 3, 4}, .packed = true, .checked = true}},
      {"a fixed array in pages", {.size = {12, 12, 20}, .chunk = {1, 1, 1}}},
      {"an extensible array", {.size = {40, 5, 6}, .chunk = {1, 2, 3}, .most = {kAny, 5, 6}, .packed = true}},
      {"an extensible array along x", {.size = {4, 5, 90}, .chunk = {2, 3, 1}, .most = {4, 5, kAny}}},
      {"a tree", {.chunk = {2, 3, 4}, .most = {kAny, kAny, 6}, .packed = true}},
      {"a deep tree", {.size = {10, 10, 20}, .chunk = {1, 1, 1}, .most = {kAny, kAny, 20}}}};
  for (const auto& [what, array] : cases) {
    write_latest(folder / "a.dream3d", array);
    expect_counting(folder / "a.dream3d", array, what);
  }
}

TEST(LatestHdf5, LargeGroupsAndManyAttributesAreRead) {
  const auto folder = test::temporary_folder();
  const LatestArray array{.size = {2, 3, 2}};
  write_latest(folder / "a.dream3d", array, 200, 30);
  expect_counting(folder / "a.dream3d", array, "200 arrays", 200);
  EXPECT_EQ(test::load_volume(folder / "a.dream3d").output<Volume>("volume").resolution, Vec3i(2, 3, 2));
}

TEST(LatestHdf5, DamagedFilesAreErrors) {
  const auto folder = test::temporary_folder();
  write_latest(folder / "a.dream3d",
               {.chunk = {2, 3, 4}, .most = {H5S_UNLIMITED, H5S_UNLIMITED, 6}, .packed = true}, 12, 12);
  const std::string whole = *read_file(folder / "a.dream3d");
  for (std::size_t size = 0; size < whole.size(); size += whole.size() / 40) {
    const std::string cut = whole.substr(0, size);
    EXPECT_EQ(test::code_of([&] {
                const Hdf5Input file(cut);
                for (const auto& [name, at] : file.children(file.find("/DataContainers/Image/CellData")))
                  file.read(at);
              }),
              "unreadable-volume")
        << size;
  }
}

TEST(LatestHdf5, TheSharedFile) {
  const fs::path path = test::shared_data() / "reports/d3d_latest.dream3d";
  if (!fs::exists(path)) GTEST_SKIP() << "no shared data";
  const auto run = test::load_volume(path);
  const auto id = run.output<Volume>("volume").find<openvdb::Int32Grid>("id");
  ASSERT_TRUE(id);
  EXPECT_EQ(run.output<Volume>("volume").extent, Vec3i(5, 4, 3));
  EXPECT_EQ(id->tree().getValue(openvdb::Coord(4, 3, 2)), 58);  // FeatureIds 59
}

}  // namespace
}  // namespace terrazzo

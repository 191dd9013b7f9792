// Files of voxels: what is in them, what reads back through LoadVolume, and what is refused.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "nodes/common/geometry/grid/voxel_source.h"
#include "nodes/common/io/provenance.h"
#include "runtime/files/base64.h"
#include "tests/nodes/export/voxel_files.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;
using test::bytes_of;
using test::code_of;
using test::expect_formula;
using test::exported;
using test::lines_of;
using test::loaded;
using test::Parameters;
using test::run_node;

// DAMASK's reader (src/VTI.f90) searches lines for elements and takes the line after a DataArray as its data.
TEST(ExportVti, KeepsToTheDialectOfDamask) {
  const Value volume = Value::of(test::formula_volume());
  for (const char* compression : {"zlib", "none"}) {
    const fs::path file =
        exported("a.vti", {{"volume", volume}, {"particles", Value::of(test::formula_particles())}},
                 {{"compression", compression}});
    const auto lines = lines_of(file);
    const auto find = [&](const std::string& text) {
      const auto it = std::find_if(lines.begin(), lines.end(),
                                   [&](const std::string& l) { return l.find(text) != std::string::npos; });
      return static_cast<std::size_t>(it - lines.begin());
    };
    const std::size_t head = find("<VTKFile "), image = find("<ImageData "), cells = find("<CellData");
    ASSERT_LT(cells, lines.size());
    EXPECT_LT(head, image);
    EXPECT_LT(image, cells);
    EXPECT_NE(lines[head].find(" type=\"ImageData\""), std::string::npos);
    EXPECT_NE(lines[head].find(" byte_order=\"LittleEndian\""), std::string::npos);
    EXPECT_NE(lines[head].find(" header_type=\"UInt64\""), std::string::npos);
    EXPECT_EQ(lines[head].find("vtkZLibDataCompressor") != std::string::npos,
              compression == std::string("zlib"));
    EXPECT_EQ(lines[image],
              "<ImageData WholeExtent=\"0 6 0 5 0 4\" Origin=\"0 0 0\" Spacing=\"0.00025 0.00025 0.00025\" "
              "Direction=\"1 0 0 0 1 0 0 0 1\">");
    const std::size_t material = find(" Name=\"material\"");
    EXPECT_EQ(material, cells + 1);
    EXPECT_EQ(lines[material],
              "<DataArray type=\"Int32\" Name=\"material\" NumberOfComponents=\"1\" format=\"binary\">");
    EXPECT_EQ(lines[material + 1].find_first_not_of(
                  "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/="),
              std::string::npos);
    EXPECT_EQ(lines[material + 2], "</DataArray>");
    if (compression == std::string("none")) {  // the length, then the numbers, in one sequence
      std::string bytes;
      ASSERT_TRUE(decode_base64(lines[material + 1], bytes));
      ASSERT_EQ(bytes.size(), 8u + 4 * 120);
      std::int32_t first[2];
      std::memcpy(first, bytes.data() + 8, sizeof first);
      EXPECT_EQ(first[0], 0);  // binder
      EXPECT_EQ(first[1], 6);  // particle 6
    }
  }
}

TEST(ExportVti, ReadsBackAsTheSameVolume) {
  const Volume v = test::formula_volume();
  for (const char* compression : {"zlib", "none"}) {
    const Volume back =
        loaded(exported("a b.vti", {{"volume", Value::of(v)}}, {{"compression", compression}}));
    EXPECT_EQ(back.resolution, v.resolution);
    EXPECT_EQ(back.grids.size(), 4u);  // material and phase come from id
    expect_formula<openvdb::Int32Grid>(back, "id", test::formula_id);
    expect_formula<openvdb::FloatGrid>(back, "density", test::formula_density);
    expect_formula<openvdb::Vec3SGrid>(
        back, "Cd", [](int x, int, int z) { return openvdb::Vec3s(0.5f, 0.25f * float(x), float(z)); });
    expect_formula<openvdb::Vec3IGrid>(back, "source",
                                       [](int x, int y, int z) { return openvdb::Vec3i(x, y, z); });
    const auto id = back.find<openvdb::Int32Grid>("id");
    EXPECT_EQ(id->transform(), *voxel_transform(0.25));
    EXPECT_EQ(id->background(), -1);
    EXPECT_EQ(id->activeVoxelCount(), v.find<openvdb::Int32Grid>("id")->activeVoxelCount());
  }
}

TEST(ExportVti, ABlockKeepsItsPlace) {
  Volume v = test::formula_volume();
  v.resolution = Vec3i::Zero();
  for (auto& g : v.grids) {  // id has inactive voxels at the border, the others do not
    if (g->getName() != "density") continue;
    auto moved = openvdb::FloatGrid::create(0);
    moved->setName("density");
    moved->setTransform(voxel_transform(0.25));
    moved->tree().setValue(openvdb::Coord(-3, 7, 100), 5);
    moved->tree().setValue(openvdb::Coord(-1, 9, 101), 6);
    v.grids = {moved};
    break;
  }
  const Volume back = loaded(exported("a.vti", {{"volume", Value::of(v)}}));
  EXPECT_EQ(back.resolution, Vec3i::Zero());
  const auto density = back.find<openvdb::FloatGrid>("density");
  ASSERT_TRUE(density);
  EXPECT_EQ(density->tree().getValue(openvdb::Coord(-3, 7, 100)), 5);
  EXPECT_EQ(density->tree().getValue(openvdb::Coord(-1, 9, 101)), 6);
  EXPECT_EQ(density->activeVoxelCount(), 3u * 3 * 2);
}

TEST(ExportVti, WritesATableOfItsNumbers) {
  const fs::path file = exported(
      "a.vti",
      {{"volume", Value::of(test::formula_volume())}, {"particles", Value::of(test::formula_particles())}},
      {{"regions", "phases"}});
  const auto lines = lines_of(file.parent_path() / "a.vti.csv");
  ASSERT_EQ(lines.size(), 6u);
  EXPECT_EQ(lines[0],
            "number,name,kind,particle,class,phase,voxels,volume mm³,fraction,size mm,equivalent diameter "
            "mm,color_r,color_g,color_b");
  EXPECT_EQ(lines[1].substr(0, 20), "0,BINDER,binder,,,0,");
  EXPECT_EQ(lines[2].substr(0, 19), "1,PHASE_0,phase,,0,");
  EXPECT_EQ(lines[5].substr(0, 15), "4,VOIDS,void,,,");
  EXPECT_EQ(
      lines_of(exported("b.vti", {{"volume", Value::of(test::formula_volume())}}, {{"grids", "[density]"}}))
          .size(),
      lines_of(exported("c.vti", {{"volume", Value::of(test::formula_volume())}}, {{"grids", "[id]"}}))
          .size());
}

TEST(ExportNpy, ReadsBackAsTheSameGrid) {
  const Value v = Value::of(test::formula_volume());
  const fs::path id = exported("a.npy", {{"volume", v}});
  expect_formula<openvdb::Int32Grid>(loaded(id, {{"grid", "id"}, {"spacing", "0.25"}}), "id",
                                     test::formula_id);
  const fs::path density = exported("a.npy", {{"volume", v}}, {{"grids", "density"}});
  expect_formula<openvdb::FloatGrid>(loaded(density, {{"spacing", "0.25"}}), "density",
                                     test::formula_density);
  EXPECT_EQ(code_of([&] { loaded(density, {{"spacing", "0.25"}, {"grid", "id"}}); }), "bad-labels");
  EXPECT_EQ(code_of([&] { loaded(density); }), "no-spacing");
  EXPECT_EQ(code_of([&] { loaded(density, {{"spacing", "1e-12"}}); }), "bad-value");
  const fs::path color = exported("a.npy", {{"volume", v}}, {{"grids", "Cd"}});
  EXPECT_EQ(fs::file_size(color) - fs::file_size(density), 2u * 4 * 120);
  EXPECT_EQ(code_of([&] { loaded(color, {{"spacing", "0.25"}}); }), "not-a-volume");
}

TEST(ExportNifti, ReadsBackAsTheSameGrid) {
  const Value v = Value::of(test::formula_volume());
  for (const char* name : {"a.nii", "a.nii.gz"}) {
    const fs::path id = exported(name, {{"volume", v}});
    const Volume back = loaded(id, {{"grid", "id"}, {"intercept", "-1"}});  // the file's binder is 0
    expect_formula<openvdb::Int32Grid>(back, "id", test::formula_id);
    EXPECT_NEAR(back.grids[0]->voxelSize()[0], 0.25, 1e-7);
    expect_formula<openvdb::FloatGrid>(loaded(exported(name, {{"volume", v}}, {{"grids", "density"}})),
                                       "density", test::formula_density);
  }
}

TEST(ExportVdb, WholeNumbersBecomeFloatsAndComeBack) {
  const Volume v = test::formula_volume();
  for (const char* type : {"float", "int32"}) {
    const fs::path file = exported("a.vdb", {{"volume", Value::of(v)}}, {{"id_type", type}});
    openvdb::io::File vdb(file.string());
    vdb.open();
    EXPECT_EQ(vdb.readGrid("id")->valueType(), type);
    EXPECT_EQ(vdb.readGrid("source")->valueType(), type == std::string("float") ? "vec3s" : "vec3i");
    // What LoadVolume returns is the same value as before, with equal bytes.
    EXPECT_EQ(bytes_of(loaded(file)), bytes_of(v)) << type;
  }
  // Another program's floats stay floats.
  Volume edited = v;
  for (auto& g : edited.grids)
    if (g->getName() == "id") {
      auto floats = openvdb::FloatGrid::create(-1);
      floats->setName("id");
      floats->setTransform(voxel_transform(0.25));
      floats->insertMeta("stored_from", openvdb::StringMetadata("int32"));
      floats->tree().setValue(openvdb::Coord(1, 2, 3), 0.5f);
      g = floats;
    }
  EXPECT_TRUE(loaded(exported("a.vdb", {{"volume", Value::of(edited)}})).find<openvdb::FloatGrid>("id"));
}

TEST(VoxelFiles, ContainTheirProvenance) {
  const Volume v = test::formula_volume();
  const auto of = [&](const std::string& name, Parameters parameters = {}) {
    const std::string text = read_provenance(exported(name, {{"volume", Value::of(v)}}, parameters));
    return nlohmann::json::parse(text, nullptr, false);
  };
  const auto expected = of("a.vdb");
  ASSERT_TRUE(expected.is_object());
  for (const char* name : {"a.vti", "a.inp", "a.nii", "a.nii.gz"}) EXPECT_EQ(of(name), expected) << name;
  EXPECT_EQ(of("a.vti", {{"compression", "none"}}), expected);
  const fs::path empty = test::temporary_folder() / "b.vti";
  for (const char* name : {"b.vti", "b.inp", "b.usda", "b.nii", "b.nii.gz"}) {
    std::ofstream(empty.parent_path() / name) << " Name=\"provenance\"\nAAAA\n**provenance";
    EXPECT_EQ(read_provenance(empty.parent_path() / name), "") << name;
  }
}

TEST(VoxelFiles, SayWhatTheyCannotHold) {
  const Volume v = test::formula_volume();
  const auto code = [&](const std::string& path, const Volume& volume, Parameters parameters = {}) {
    const fs::path out = test::temporary_folder();
    parameters["path"] = path;
    const std::string found = code_of([&] {
      run_node("Export", {{"volume", Value::of(volume)}}, parameters, out);
    });
    EXPECT_EQ(test::files_in(out), 0u) << path;
    return found;
  };
  for (const char* path : {"a.vti", "a.inp", "a.npy", "a.nii.gz"})
    EXPECT_EQ(code(path, Volume()), "no-grids");
  EXPECT_EQ(code("a.vti", v, {{"grids", "[nothing]"}}), "no-such-grid");
  EXPECT_EQ(code("a.vdb", v, {{"grids", "[nothing]"}}), "no-such-grid");
  EXPECT_EQ(code("a.vti", v, {{"regions", "phases"}}), "missing-input");
  EXPECT_EQ(code("a.nii", v, {{"grids", "Cd"}}), "not-a-scalar");
  EXPECT_EQ(code("a.npy", v, {{"grids", "[id, Cd]"}}), "several-grids");

  Volume bad = v;
  bad.grids.clear();
  auto density = openvdb::FloatGrid::create(0);
  density->setName("density");
  density->setTransform(voxel_transform(0.25));
  bad.grids.push_back(density);
  EXPECT_EQ(code("a.inp", bad), "no-id");
  density->tree().setValue(openvdb::Coord(1, 2, 3), std::nanf(""));
  EXPECT_EQ(code("a.vti", bad), "bad-values");
  EXPECT_EQ(code("a.npy", bad), "bad-values");

  Volume tilted = v;
  auto turned = v.find<openvdb::FloatGrid>("density")->deepCopy();
  turned->transform().postRotate(0.1, openvdb::math::Z_AXIS);
  tilted.grids = {turned};
  EXPECT_EQ(code("a.vti", tilted), "tilted-volume");
  Volume mixed = v;
  auto coarse = v.find<openvdb::FloatGrid>("density")->deepCopy();
  coarse->setTransform(voxel_transform(0.5));
  coarse->setName("coarse");
  mixed.grids.push_back(coarse);
  EXPECT_EQ(code("a.vti", mixed), "size-mismatch");

  Volume huge = v;  // 10⁹ voxels, nearly all of them tiles
  huge.resolution = Vec3i(1000, 1000, 1000);
  EXPECT_EQ(code("a.inp", huge), "too-large");
  huge.resolution = Vec3i(40000, 2, 2);
  EXPECT_EQ(code("a.nii", huge), "too-large");

  Volume many = v;
  auto ids = openvdb::Int32Grid::create(-1);
  ids->setName("id");
  ids->setTransform(voxel_transform(0.25));
  ids->tree().setValue(openvdb::Coord(0, 0, 0), 16777217);
  many.grids = {ids};
  EXPECT_EQ(code("a.vdb", many), "too-many-labels");
  EXPECT_EQ(code_of([&] { exported("a.vdb", {{"volume", Value::of(many)}}, {{"id_type", "int32"}}); }), "");

  Volume named = v;
  auto taken = v.find<openvdb::FloatGrid>("density")->deepCopy();
  taken->setName("material");
  named.grids.push_back(taken);
  EXPECT_EQ(code("a.vti", named), "bad-names");
}

TEST(VoxelFiles, FullDisksAreErrors) {
  Volume v = test::formula_volume();
  v.resolution = Vec3i(40, 40, 40);
  for (const char* path : {"a.vti", "a.inp", "a.npy", "a.nii"}) {
    const fs::path out = test::temporary_folder();
    const test::FullDisk full(2000);
    EXPECT_EQ(
        code_of([&] {
          run_node("Export", {{"volume", Value::of(v)}}, {{"path", path}, {"compression", "none"}}, out);
        }),
        "write-failed")
        << path;
    EXPECT_EQ(test::files_in(out), 0u) << path;
  }
}

}  // namespace
}  // namespace terrazzo

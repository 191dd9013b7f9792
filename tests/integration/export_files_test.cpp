// Reads exported files with other programs, and their files with LoadVolume: Khronos' glTF validator,
// three.js, tinyusdz, OpenVDB's tools, VTK, NumPy.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "nodes/data/volume.h"
#include "nodes/export/formats/gltf.h"
#include "tests/nodes/bodies/carve/carve_support.h"
#include "tests/nodes/export/export_support.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/code_of.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

TEST(ExportedGltf, IsValidAndOpensInThreeJs) {
  const fs::path check = test::npm_check("gltf_check");
  if (check.empty())
    GTEST_SKIP() << "node and npm are not installed, or cannot install gltf-validator and three";
  const fs::path out = test::temporary_folder();
  const Particles particles = test::some_particles(500);
  write_glb(out / "p.glb", particles, test::two_shapes(), R"({"graph": "a.yaml", "nodes": {"pack": "k"}})");
  write_glb(out / "s.glb", test::two_shapes());

  const auto examine = [&](const std::string& name) { return test::run_npm_check(check, out / name); };
  const auto p = examine("p.glb");
  ASSERT_TRUE(p.is_object());
  EXPECT_EQ(p["errors"], 0) << p["messages"].dump(1);
  EXPECT_EQ(p["warnings"], 0) << p["messages"].dump(1);
  EXPECT_EQ(p["generator"], "Terrazzo");
  EXPECT_EQ(p["extras"]["nodes"]["pack"], "k");
  ASSERT_EQ(p["instanced"].size(), 2u);
  std::size_t instances = 0;
  for (const auto& mesh : p["instanced"]) {
    instances += mesh["count"].get<std::size_t>();
    EXPECT_EQ(mesh["colors"], mesh["count"]);
    EXPECT_EQ(mesh["components"], 3);
    const std::int32_t shape = mesh["name"] == "faceted" ? 0 : 1;
    std::size_t first = 0;
    while (particles.shape[first] != shape) ++first;
    const Vec3 at = particles.position[first] * 0.001;
    EXPECT_NEAR(mesh["firstPosition"][0], at.x(), 1e-7);
    EXPECT_NEAR(mesh["firstPosition"][1], at.z(), 1e-7);
    EXPECT_NEAR(mesh["firstPosition"][2], -at.y(), 1e-7);
    EXPECT_NEAR(mesh["firstScale"], particles.scale[first], 1e-4);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(mesh["firstColor"][k], particles.color[first][k], 1e-6);
  }
  EXPECT_EQ(instances, 500u);
  const auto s = examine("s.glb");
  ASSERT_TRUE(s.is_object());
  EXPECT_EQ(s["errors"], 0) << s["messages"].dump(1);
  EXPECT_EQ(s["meshes"].size(), 3u);
}

// A carved body with colors of vertices, and with a texture.
TEST(ExportedGltf, CarvedBodiesAreValidAndOpenInThreeJs) {
  const fs::path check = test::npm_check("gltf_check");
  if (check.empty())
    GTEST_SKIP() << "node and npm are not installed, or cannot install gltf-validator and three";
  const fs::path out = test::temporary_folder();
  const auto carved = test::carved_ball();
  test::run_node("Export", {{"shapes", carved.outputs.at("shapes")}}, {{"path", "c.glb"}}, out);
  test::run_node("Export", {{"shapes", carved.outputs.at("shapes")}, {"image", carved.outputs.at("texture")}},
                 {{"path", "t.glb"}}, out);
  for (const char* name : {"c.glb", "t.glb"}) {
    const auto j = test::run_npm_check(check, out / name);
    ASSERT_TRUE(j.is_object());
    EXPECT_EQ(j["errors"], 0) << j["messages"].dump(1);
    EXPECT_EQ(j["warnings"], 0) << j["messages"].dump(1);
    EXPECT_EQ(j["meshes"].size(), 1u);
  }
}

TEST(ExportedGltf, NodesAreValidAndOpenInThreeJs) {
  const fs::path check = test::npm_check("gltf_check");
  if (check.empty())
    GTEST_SKIP() << "node and npm are not installed, or cannot install gltf-validator and three";
  const fs::path out = test::temporary_folder();
  const Particles particles = test::some_particles(300);
  write_glb(out / "n.glb", particles, test::two_shapes(), R"({"graph": "a.yaml"})", {}, Instancing::Nodes,
            32);
  const auto n = test::run_npm_check(check, out / "n.glb");
  ASSERT_TRUE(n.is_object());
  EXPECT_EQ(n["errors"], 0) << n["messages"].dump(1);
  EXPECT_EQ(n["warnings"], 0) << n["messages"].dump(1);
  EXPECT_EQ(n["extras"]["graph"], "a.yaml");
  EXPECT_TRUE(n["instanced"].empty());
  ASSERT_EQ(n["nodes"].size(), 300u);
  for (const auto& node : n["nodes"]) {
    const auto i = node["extras"]["id"].get<std::size_t>();
    EXPECT_EQ(node["name"], (particles.shape[i] == 0 ? "faceted_" : "smooth_") + std::to_string(i));
    const Vec3 at = particles.position[i] * 0.001;
    EXPECT_NEAR(node["position"][0], at.x(), 1e-7);
    EXPECT_NEAR(node["position"][1], at.z(), 1e-7);
    EXPECT_NEAR(node["position"][2], -at.y(), 1e-7);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(node["extras"]["color"][k], particles.color[i][k], 1e-6);
      EXPECT_NEAR(node["color"][k], particles.color[i][k], 0.5);
    }
  }
}

fs::path exported(const std::string& name, const Volume& volume,
                  std::map<std::string, std::string> parameters = {}, const Particles* particles = nullptr) {
  const fs::path out = test::temporary_folder();
  std::multimap<std::string, Value> inputs = {{"volume", Value::of(volume)}};
  if (particles) inputs.emplace("particles", Value::of(*particles));
  parameters["path"] = name;
  test::run_node("Export", inputs, parameters, out);
  return out / name;
}

TEST(ExportedVdb, IsListedByVdbPrint) {
  if (!test::has_program("vdb_print")) GTEST_SKIP() << "vdb_print is not installed";
  const auto run = test::run_command({"vdb_print", "-l", exported("v.vdb", test::formula_volume()).string()});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  for (const char* words : {"density", "Cd", "id", "stored_from", "provenance", "0.25"})
    EXPECT_NE(run.out.find(words), std::string::npos) << words << " in\n" << run.out;
}

TEST(ExportedVdb, EveryGridOpensInPython) {
  if (!test::has_python_module("pyopenvdb")) GTEST_SKIP() << "python3-openvdb is not installed";
  const auto j = test::run_reader("read_vdb.py", {exported("v.vdb", test::formula_volume()).string()});
  ASSERT_TRUE(j.is_object());
  EXPECT_EQ(j["metadata"], nlohmann::json({"creator", "period", "provenance"}));
  ASSERT_EQ(j["grids"].size(), 4u);
  EXPECT_EQ(j["grids"]["id"]["type"], "float");
  EXPECT_EQ(j["grids"]["source"]["type"], "vec3s");
  EXPECT_EQ(j["grids"]["id"]["background"], -1);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(j["grids"]["id"]["values"][i], test::formula_id(i, i, i));
    EXPECT_EQ(j["grids"]["density"]["values"][i], test::formula_density(i, i, i));
    EXPECT_EQ(j["grids"]["source"]["values"][i], nlohmann::json({i, i, i}));
  }
}

TEST(ExportedVti, OpensInVtkWithEqualValues) {
  if (!test::has_python_module("vtkmodules.vtkIOXML"))
    GTEST_SKIP() << "python3-vtk9 is not installed; ./dev test --all installs it";
  const Particles particles = test::formula_particles();
  for (const char* compression : {"zlib", "none"}) {
    const auto j = test::run_reader(
        "read_vtk.py",
        {exported("a b.vti", test::formula_volume(), {{"compression", compression}}, &particles).string()});
    ASSERT_TRUE(j.is_object());
    EXPECT_EQ(j["extent"], nlohmann::json({0, 6, 0, 5, 0, 4}));
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(j["spacing"][k], 0.00025, 1e-15);
    EXPECT_EQ(j["origin"], nlohmann::json({0, 0, 0}));
    EXPECT_EQ(j["fields"]["period"], nlohmann::json({"6", "5", "4"}));
    EXPECT_TRUE(nlohmann::json::parse(j["fields"]["provenance"][0].get<std::string>()).is_object());
    EXPECT_EQ(j["arrays"].size(), 6u);
    const auto& a = j["arrays"];
    EXPECT_EQ(a["material"]["type"], "int");
    EXPECT_EQ(a["Cd"]["components"], 3);
    const std::vector<int> number = {0, 1, 2, 3, 4, -1, 5, 6},
                           phase = {0, 1, 2, 3, 4, -1, 3, 1};  // of id − 1
    std::size_t i = 0;
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 6; ++x, ++i) {
          const int id = test::formula_id(x, y, z);
          ASSERT_EQ(a["id"]["values"][i], id);
          ASSERT_EQ(a["material"]["values"][i], number[id + 1]);
          ASSERT_EQ(a["phase"]["values"][i], phase[id + 1]);
          ASSERT_EQ(a["density"]["values"][i], test::formula_density(x, y, z));
          ASSERT_EQ(a["Cd"]["values"][3 * i + 1], 0.25 * x);
          ASSERT_EQ(a["source"]["values"][3 * i + 2], z);
        }
  }
}

TEST(ExportedNifti, OpensInVtkWithEqualValues) {
  if (!test::has_python_module("vtkmodules.vtkIOImage"))
    GTEST_SKIP() << "python3-vtk9 is not installed; ./dev test --all installs it";
  for (const char* name : {"a.nii", "a.nii.gz"}) {
    const auto j = test::run_reader("read_vtk.py", {exported(name, test::formula_volume()).string()});
    ASSERT_TRUE(j.is_object());
    EXPECT_NEAR(j["spacing"][1], 0.25, 1e-7);
    const auto& values = j["arrays"].begin().value()["values"];
    ASSERT_EQ(values.size(), 120u);
    std::size_t i = 0;
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 6; ++x, ++i) ASSERT_EQ(values[i], test::formula_id(x, y, z) + 1);
  }
}

TEST(ExportedNpy, OpensInNumPyWithEqualValues) {
  if (!test::has_python_module("numpy")) GTEST_SKIP() << "python3-numpy is not installed";
  const auto id = test::run_reader("read_npy.py", {exported("a.npy", test::formula_volume()).string()});
  EXPECT_EQ(id["shape"], nlohmann::json({6, 5, 4}));
  EXPECT_EQ(id["type"], "int32");
  const auto color = test::run_reader(
      "read_npy.py", {exported("a.npy", test::formula_volume(), {{"grids", "Cd"}}).string()});
  EXPECT_EQ(color["shape"], nlohmann::json({6, 5, 4, 3}));
  std::size_t i = 0;
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x, ++i) {
        ASSERT_EQ(id["values"][i], test::formula_id(x, y, z));
        ASSERT_EQ(color["values"][i], 0.5);
        ASSERT_EQ(color["values"][120 + i], 0.25 * x);
        ASSERT_EQ(color["values"][240 + i], z);
      }
}

Volume loaded(const fs::path& file, std::map<std::string, std::string> parameters = {}) {
  parameters["path"] = file.string();
  return test::run_node("LoadVolume", {}, parameters).output<Volume>("volume");
}

TEST(ForeignNpy, OpensInLoadVolume) {
  if (!test::has_python_module("numpy")) GTEST_SKIP() << "python3-numpy is not installed";
  const fs::path file = test::temporary_folder() / "a.npy";
  for (const char* type : {"u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8", "<f4", "<f8", ">i2", ">f4"})
    for (const char* order : {"C", "F"}) {
      test::run_reader("write_npy.py", {file.string(), type, order});
      const auto grid = loaded(file, {{"spacing", "2"}}).find<openvdb::FloatGrid>("density");
      ASSERT_TRUE(grid);
      EXPECT_EQ(grid->voxelSize(), openvdb::Vec3d(2));
      for (int z = 0; z < 2; ++z)
        for (int y = 0; y < 3; ++y)
          for (int x = 0; x < 4; ++x)
            ASSERT_EQ(grid->tree().getValue(openvdb::Coord(x, y, z)), x + 10 * y + 100 * z) << type << order;
    }
  test::run_reader("write_npy.py", {file.string(), "<c8", "C"});
  EXPECT_EQ(test::code_of([&] { loaded(file, {{"spacing", "2"}}); }), "unreadable-volume");
}

TEST(ForeignVti, OpensInLoadVolume) {
  if (!test::has_python_module("vtkmodules.vtkIOXML"))
    GTEST_SKIP() << "python3-vtk9 is not installed; ./dev test --all installs it";
  const fs::path file = test::temporary_folder() / "a.vti";
  for (const char* mode : {"ascii", "binary", "plain", "appended", "raw"}) {
    test::run_reader("write_vti.py", {file.string(), mode});
    const Volume v = loaded(file);
    const auto a = v.find<openvdb::Int32Grid>("a");
    const auto vectors = v.find<openvdb::Vec3SGrid>("v");
    ASSERT_TRUE(a && vectors) << mode;
    EXPECT_EQ(a->voxelSize(), openvdb::Vec3d(0.5)) << mode;
    EXPECT_EQ(loaded(file, {{"grid", "a"}, {"spacing", "3"}}).grids.at(0)->voxelSize(), openvdb::Vec3d(3));
    for (int z = 0; z < 2; ++z)
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 4; ++x) {
          const int n = x + 10 * y + 100 * z;
          ASSERT_EQ(a->tree().getValue(openvdb::Coord(x, y, z)), n) << mode;
          ASSERT_EQ(vectors->tree().getValue(openvdb::Coord(x, y, z)),
                    openvdb::Vec3s(float(n), 0.5f * float(n), float(-n)))
              << mode;
        }
  }
}

TEST(ExportedUsda, OpensInTinyUsdz) {
  const fs::path check = test::npm_check("usda_check");
  if (check.empty()) GTEST_SKIP() << "node and npm are not installed, or cannot install tinyusdz";
  const fs::path out = test::temporary_folder();
  const Particles particles = test::some_particles(200);
  test::run_node("Export",
                 {{"particles", Value::of(particles)},
                  {"shapes", Value::of(test::two_shapes())},
                  {"volume", Value::of(test::formula_volume())}},
                 {{"path", "a b.usda"}}, out);
  const auto j = test::run_npm_check(check, out / "a b.usda");
  ASSERT_TRUE(j.is_object());
  EXPECT_EQ(j["error"], "");
  ASSERT_TRUE(j["parsed"].get<bool>()) << j.dump(1);
  const std::string text = j["text"];
  for (const char* words : {"PointInstancer", "protoIndices", "UsdPrimvarReader_float3", "OpenVDBAsset",
                            "./a b.vdb", "metersPerUnit = 0.001", "faceVertexIndices", "subdivisionScheme"})
    EXPECT_NE(text.find(words), std::string::npos) << words;
  // The arrays, as tinyusdz read them.
  const auto numbers = [&](const std::string& name) {
    const auto begin = text.find('[', text.find(name + " = ")), end = text.find(']', begin);
    std::string inside = text.substr(begin + 1, end - begin - 1);
    std::replace_if(
        inside.begin(), inside.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
    std::istringstream in(inside);
    return std::vector<double>(std::istream_iterator<double>(in), {});
  };
  const auto position = numbers("positions"), orientation = numbers("orientations"),
             scale = numbers("scales"), color = numbers("primvars:displayColor"),
             prototype = numbers("protoIndices");
  ASSERT_EQ(position.size(), 600u);
  ASSERT_EQ(orientation.size(), 800u);
  ASSERT_EQ(scale.size(), 600u);
  ASSERT_EQ(color.size(), 600u);
  ASSERT_EQ(prototype.size(), 200u);
  for (std::size_t i = 0; i < 200; ++i) {
    EXPECT_EQ(prototype[i], particles.shape[i]);
    EXPECT_NEAR(orientation[4 * i], particles.orientation[i].w(), 0.0005);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(position[3 * i + k], particles.position[i][static_cast<Eigen::Index>(k)], 1e-5);
      EXPECT_NEAR(scale[3 * i + k], particles.scale[i], 1e-6);
      EXPECT_NEAR(color[3 * i + k], particles.color[i][static_cast<Eigen::Index>(k)], 1e-6);
    }
  }
}

}  // namespace
}  // namespace terrazzo

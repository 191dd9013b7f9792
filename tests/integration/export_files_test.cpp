// Reads exported files with other programs: Khronos' glTF validator, three.js, OpenVDB's tools, Python.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "nodes/data/volume.h"
#include "nodes/export/gltf.h"
#include "nodes/export/vdb_file.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

struct Shell {
  int exit_code = -1;
  std::string out;
};

Shell shell(const std::string& command) {
  Shell result;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (!pipe) return result;
  std::array<char, 4096> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    result.out.append(buffer.data(), n);
  const int status = ::pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

bool has(const std::string& program) {
  return shell("command -v " + program + " >/dev/null 2>&1").exit_code == 0;
}

// A folder outside the source tree with the check and its packages, created once and kept for later runs.
// Empty if it cannot be created.
fs::path gltf_check() {
  const fs::path source = fs::path(TERRAZZO_SOURCE) / "tests/integration/gltf_check";
  const fs::path folder = fs::temp_directory_path() / "terrazzo-gltf-check";
  std::error_code error;
  fs::create_directories(folder, error);
  for (const char* name : {"package.json", "check.mjs"})
    fs::copy_file(source / name, folder / name, fs::copy_options::overwrite_existing, error);
  const std::string in = "cd '" + folder.string() + "' && ";
  if (shell(in + "npm ls >/dev/null 2>&1").exit_code != 0 &&
      shell(in + "timeout 120 npm install --no-audit --no-fund --no-package-lock >/dev/null 2>&1")
              .exit_code != 0)
    return {};
  return folder;
}

TEST(ExportedGltf, IsValidAndOpensInThreeJs) {
  if (!has("node") || !has("npm")) GTEST_SKIP() << "node and npm are not installed";
  const fs::path check = gltf_check();
  if (check.empty()) GTEST_SKIP() << "npm cannot install gltf-validator and three here";
  const fs::path out = test::temporary_folder();
  const Particles particles = test::some_particles(500);
  write_glb(out / "p.glb", particles, test::two_shapes(), R"({"graph": "a.yaml", "nodes": {"pack": "k"}})");
  write_glb(out / "s.glb", test::two_shapes());

  const auto examine = [&](const std::string& name) {
    const Shell run = shell("node '" + (check / "check.mjs").string() + "' '" + (out / name).string() + "'");
    EXPECT_EQ(run.exit_code, 0) << run.out;
    return nlohmann::json::parse(run.out, nullptr, false);
  };
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

fs::path some_vdb() {
  initialize_openvdb();
  Volume v;
  v.resolution = Vec3i(16, 16, 16);
  auto density = openvdb::FloatGrid::create(0);
  density->setName("density"), density->setGridClass(openvdb::GRID_FOG_VOLUME);
  auto color = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  color->setName("Cd");
  auto id = openvdb::Int32Grid::create(-1);
  id->setName("id");
  density->denseFill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(9)), 1.0f);
  color->denseFill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(15)),
                   openvdb::Vec3s(0.5f, 0.25f, 0.125f));
  id->denseFill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(9)), 42);
  for (const openvdb::GridBase::Ptr& g :
       {openvdb::GridBase::Ptr(density), openvdb::GridBase::Ptr(color), openvdb::GridBase::Ptr(id)})
    g->setTransform(voxel_transform(0.25)), v.grids.push_back(g);
  const fs::path file = test::temporary_folder() / "v.vdb";
  write_vdb(file, v, R"({"graph": "a.yaml"})");
  return file;
}

TEST(ExportedVdb, IsListedByVdbPrint) {
  if (!has("vdb_print")) GTEST_SKIP() << "vdb_print is not installed";
  const Shell run = shell("vdb_print -l '" + some_vdb().string() + "' 2>&1");
  EXPECT_EQ(run.exit_code, 0) << run.out;
  for (const char* words : {"density", "Cd", "id", "a.yaml", "0.25"})
    EXPECT_NE(run.out.find(words), std::string::npos) << words << " in\n" << run.out;
}

TEST(ExportedVdb, OpensInPython) {
  if (shell("/usr/bin/python3 -c 'import pyopenvdb' >/dev/null 2>&1").exit_code != 0)
    GTEST_SKIP() << "python3-openvdb is not installed";
  // Debian's pyopenvdb does not support integer grids; vdb_print and other programs read `id`.
  const Shell run =
      shell("/usr/bin/python3 -c \"\nimport pyopenvdb as vdb, json\nf = '" + some_vdb().string() +
            "'\ndensity, color = vdb.read(f, 'density'), vdb.read(f, 'Cd')\n"
            "print(json.dumps(dict(meta=vdb.readMetadata(f), active=density.activeVoxelCount(), "
            "fog=density.gridClass, size=list(color.transform.voxelSize()), "
            "center=list(color.transform.indexToWorld((0, 0, 0))), "
            "color=list(color.getConstAccessor().getValue((3, 4, 5))))))\n\" 2>&1");
  ASSERT_EQ(run.exit_code, 0) << run.out;
  const auto j = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_TRUE(j.is_object()) << run.out;
  EXPECT_EQ(j["meta"]["creator"], "Terrazzo");
  EXPECT_EQ(nlohmann::json::parse(j["meta"]["provenance"].get<std::string>())["graph"], "a.yaml");
  EXPECT_EQ(j["fog"], "fog volume");
  EXPECT_EQ(j["active"], 1000);
  EXPECT_EQ(j["size"], nlohmann::json({0.25, 0.25, 0.25}));
  EXPECT_EQ(j["center"], nlohmann::json({0.125, 0.125, 0.125}));
  EXPECT_EQ(j["color"], nlohmann::json({0.5, 0.25, 0.125}));
}

}  // namespace
}  // namespace terrazzo

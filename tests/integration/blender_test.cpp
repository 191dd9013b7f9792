// The add-on for Blender, run in Blender without a window: instances, colors, ids, voxels.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "nodes/common/geometry/grid/voxel_grids.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/indices.h"
#include "nodes/data/opaque_volume.h"
#include "nodes/export/formats/gltf.h"
#include "nodes/export/formats/vdb_file.h"
#include "runtime/random.h"
#include "tests/nodes/bodies/carve/carve_support.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

nlohmann::json in_blender(const fs::path& file) {
  const fs::path source = test::source_folder(), out = file.string() + ".json";
  const auto run = test::run_command({"blender", "--background", "--factory-startup", "--python",
                                      (source / "tests/integration/readers/read_blender.py").string(), "--",
                                      (source / "nodes/export/blender/terrazzo_import.py").string(),
                                      file.string(), out.string()});
  std::ifstream in(out);
  auto json = nlohmann::json::parse(in, nullptr, false);
  EXPECT_FALSE(json.is_discarded()) << run.out << run.err;
  return json;
}

// Voxels of 0.5 mm that fill a box of 20 × 28 × 40 mm. Blender tells the box of whole blocks of 8 voxels.
void write_grids(const fs::path& file) {
  Volume v;
  v.resolution = Vec3i(40, 56, 80);
  add_number_grid(v, "density", v.resolution, Vec3::Constant(0.5), {},
                  [](std::size_t i) { return 0.5f + float(i % 2); });
  write_vdb(file, v, "{}");
}

TEST(BlenderAddOn, ImportsParticlesWithColorsAndIdsAndTheVolume) {
  if (!test::has_program("blender")) GTEST_SKIP() << "blender is not installed";
  const fs::path out = test::temporary_folder();
  const Particles particles = test::some_particles(300);
  const Shapes shapes = test::two_shapes();
  write_glb(out / "p.glb", particles, shapes, "{}");
  write_grids(out / "p.vdb");
  const auto j = in_blender(out / "p.glb");
  EXPECT_EQ(j["result"], std::vector<std::string>{"FINISHED"}) << j["error"];
  // One mesh per shape with particles; faces of the faceted shape share their vertices again.
  EXPECT_EQ(j["meshes"]["faceted"], (std::vector<int>{4, 4}));
  EXPECT_EQ(j["meshes"].size(), 2u);
  ASSERT_EQ(j["particles"].size(), 300u);
  std::set<std::size_t> ids;
  for (const auto& p : j["particles"]) {
    const auto i = p["id"].get<std::size_t>();
    ASSERT_LT(i, 300u);
    ids.insert(i);
    EXPECT_EQ(p["mesh"], shapes.shapes[static_cast<std::size_t>(particles.shape[i])].name);
    EXPECT_EQ(p["material"], "Terrazzo particle");
    // A corner of the tetrahedron: whichever Blender has first, one must be there, in mm with z up.
    double nearest = 1e9;
    for (const Vec3& v : shapes.shapes[0].mesh.vertices) {
      const Vec3 at = particles.position[i] + particles.scale[i] * (particles.orientation[i] * v);
      nearest = std::min(nearest, (at - Vec3(p["corner"][0], p["corner"][1], p["corner"][2])).norm());
    }
    EXPECT_LT(nearest, 1e-4);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(p["place"][static_cast<std::size_t>(k)], particles.position[i][k], 1e-4);
      EXPECT_NEAR(p["color"][static_cast<std::size_t>(k)], particles.color[i][k], 1e-6);
    }
  }
  EXPECT_EQ(ids.size(), 300u);
  ASSERT_EQ(j["volumes"].size(), 1u);
  EXPECT_TRUE(j["volumes"][0]["hidden"].get<bool>());
  const auto& grid = j["volumes"][0]["grids"]["density"];
  EXPECT_EQ(grid[0], "FLOAT");
  // The box reaches from the first to the last voxel center.
  const auto& box = j["volumes"][0]["box"];
  const int size[] = {40, 56, 80};
  for (std::size_t a = 0; a < 3; ++a) {
    double low = 1e9, high = -1e9;
    for (const auto& corner : box)
      low = std::min<double>(low, corner[a]), high = std::max<double>(high, corner[a]);
    EXPECT_NEAR((high - low) / grid[2][a][a].get<double>() + 1, size[a], 1e-3);
    EXPECT_NEAR(low, 0.25, 1e-5);
  }
}

TEST(BlenderAddOn, ImportsAVolumeAloneAndRefusesOtherFiles) {
  if (!test::has_program("blender")) GTEST_SKIP() << "blender is not installed";
  const fs::path out = test::temporary_folder();
  write_grids(out / "v.vdb");
  const auto volume = in_blender(out / "v.vdb");
  ASSERT_EQ(volume["volumes"].size(), 1u);
  EXPECT_FALSE(volume["volumes"][0]["hidden"].get<bool>());
  EXPECT_EQ(volume["particles"].size(), 0u);

  write_glb(out / "s.glb", test::two_shapes());  // shapes without particles
  const auto shapes = in_blender(out / "s.glb");
  EXPECT_EQ(shapes["result"], std::vector<std::string>{"CANCELLED"});
  EXPECT_NE(shapes["error"].get<std::string>().find("instancing: extension"), std::string::npos);
  write_glb(out / "t.glb", test::some_particles(9), test::two_shapes(), "{}");
  fs::resize_file(out / "t.glb", fs::file_size(out / "t.glb") - 100);
  EXPECT_NE(in_blender(out / "t.glb")["error"].get<std::string>().find("truncated"), std::string::npos);
  std::ofstream(out / "v.vdb") << "nothing";
  EXPECT_NE(in_blender(out / "v.vdb")["error"].get<std::string>().find("cannot be read"), std::string::npos);
}

// Blender's own importer and exporter of glTF.
TEST(BlenderGltf, ShowsCarvedBodiesAndWritesMeshesThatLoadMeshReads) {
  if (!test::has_program("blender")) GTEST_SKIP() << "blender is not installed";
  const fs::path out = test::temporary_folder();
  const auto carved = test::carved_ball();
  const Shape& ball = carved.output<Shapes>("shapes").shapes.at(0);
  test::run_node("Export", {{"shapes", carved.outputs.at("shapes")}}, {{"path", "c.glb"}}, out);
  test::run_node("Export", {{"shapes", carved.outputs.at("shapes")}, {"image", carved.outputs.at("texture")}},
                 {{"path", "t.glb"}}, out);
  const auto imported = [&](const std::string& name, const std::vector<std::string>& more = {}) {
    const fs::path json = out / (name + ".json");
    std::vector<std::string> command = {
        "blender",
        "--background",
        "--factory-startup",
        "--python",
        (test::source_folder() / "tests/integration/readers/read_blender_mesh.py").string(),
        "--",
        (out / name).string(),
        json.string()};
    command.insert(command.end(), more.begin(), more.end());
    const auto run = test::run_command(command);
    std::ifstream in(json);
    auto j = nlohmann::json::parse(in, nullptr, false);
    EXPECT_FALSE(j.is_discarded()) << run.out << run.err;
    return j;
  };
  const auto j = imported("c.glb", {(out / "copy.glb").string()});
  ASSERT_EQ(j.size(), 1u);
  EXPECT_EQ(j[0]["name"], "ball");
  EXPECT_EQ(j[0]["polygons"], ball.mesh.triangles.size());
  ASSERT_GE(j[0]["colors"].size(), ball.mesh.vertices.size());
  for (std::size_t i = 0; i < j[0]["colors"].size(); ++i) {
    const auto& v = j[0]["vertices"][j[0]["color_of"][i].get<std::size_t>()];
    const Vec3f expected = test::carved_ball_color(1000 * Vec3(v[0], v[1], v[2]));
    for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(j[0]["colors"][i][k], expected[int(k)], 0.01);
  }
  EXPECT_EQ(imported("t.glb")[0]["textures"], std::vector<int>{256});

  // Blender's file: twice as wide, half as high again, mirrored, and elsewhere.
  const auto again = test::run_node("LoadMesh", {}, {{"path", (out / "copy.glb").string()}});
  const Shape& copy = again.output<Shapes>("shapes").shapes.at(0);
  EXPECT_NEAR(copy.volume / ball.volume, 3, 1e-4);
  EXPECT_EQ(copy.mesh.triangles.size(), ball.mesh.triangles.size());
  double longest = 0;
  for (const Vec3& v : copy.mesh.vertices) longest = std::max(longest, v.norm());
  EXPECT_NEAR(longest, 10, 0.05);
}

// The color that the add-on's material has at a point in periods: linear in encoded bytes within a slice,
// whose border continues, and linear between slices.
Vec3f color_in_blender(const std::vector<Vec3f>& encoded, int n, const Vec3& p) {
  const auto within = [&](double v) { return std::clamp((v - std::floor(v)) * n, 0.5, n - 0.5) - 0.5; };
  const double x = within(p.x()), y = within(p.y()), z = (p.z() - std::floor(p.z())) * n - 0.5;
  const int i = round_down(x), j = round_down(y), k = round_down(z);
  Vec3f out = Vec3f::Zero();
  for (int dz = 0; dz < 2; ++dz) {
    Vec3f slice = Vec3f::Zero();
    for (const auto& [dx, dy] : {std::pair(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
      const double weight = (dx ? x - i : i + 1 - x) * (dy ? y - j : j + 1 - y);
      slice += static_cast<float>(weight) * encoded[voxel_at(std::min(i + dx, n - 1), std::min(j + dy, n - 1),
                                                             (k + dz + n) % n, Vec3i(n, n, n))];
    }
    out += static_cast<float>(dz ? z - k : k + 1 - z) * srgb_to_linear(slice);
  }
  return out;
}

TEST(BlenderAddOn, ShowsTheSolidWhoseSlicesAreInAPicture) {
  if (!test::has_program("blender")) GTEST_SKIP() << "blender is not installed";
  constexpr int kVoxels = 10;  // 4 columns, 3 rows
  const Vec3i size = Vec3i::Constant(kVoxels);
  std::vector<Vec3f> encoded;  // as stored in 8 bits
  for (std::size_t i = 0; i < voxels_in(size); ++i) {
    Random r(1, 2, i);
    encoded.push_back(Vec3f(float(r.below(256)), float(r.below(256)), float(r.below(256))) / 255);
  }
  Volume v;
  v.resolution = size;
  add_vector_grid(v, "Cd", size, 0.4, {}, [&](std::size_t i) { return srgb_to_linear(encoded[i]); });
  const fs::path out = test::temporary_folder();
  test::run_node("Export", {{"volume", Value::of(v)}}, {{"path", "solid.png"}}, out);
  const fs::path source = test::source_folder();
  const auto run = test::run_command({"blender", "--background", "--factory-startup", "--python",
                                      (source / "tests/integration/readers/read_blender_solid.py").string(),
                                      "--", (source / "nodes/export/blender/terrazzo_import.py").string(),
                                      (out / "solid.png").string(), "4", (out / "o.json").string()});
  std::ifstream in(out / "o.json");
  const auto j = nlohmann::json::parse(in, nullptr, false);
  ASSERT_FALSE(j.is_discarded()) << run.out << run.err;
  EXPECT_EQ(j["result"], std::vector<std::string>{"FINISHED"});
  const int side = j["side"];
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double right = 2 * (x + 0.5) / side, up = 2 * (y + 0.5) / side;
      const Vec3f want = color_in_blender(encoded, kVoxels, Vec3(right, up, 0.3 + 0.45 * up));
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(j["pixels"][std::size_t(y * side + x) * 4 + c].get<float>(), want[c], 2e-3)
            << x << " " << y;
    }
}

}  // namespace
}  // namespace terrazzo

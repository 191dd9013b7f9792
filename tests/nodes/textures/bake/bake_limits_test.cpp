// What Bake warns of and refuses, and its maps in files.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "runtime/compute_node.h"
#include "tests/nodes/textures/bake/bake_cases.h"
#include "tests/support/all_nodes.h"
#include "tests/support/code_of.h"
#include "tests/support/readers.h"

namespace terrazzo {
namespace {
using namespace bake_cases;

TEST(Bake, WarnsOfDoubtfulMeshes) {
  const BakedSolid s = balls_on_a_lattice();
  const auto warnings = [&](const Shape& mesh, Settings settings = {}) {
    settings.emplace("resolution", "64");
    std::string all;
    for (const std::string& w : bake_of(mesh, s, settings).warnings) all += w + "\n";
    return all;
  };
  const auto has = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_EQ(warnings(rectangle({0, 0}, {6, 6}, 1)), "");

  Shape twice = rectangle({0, 0}, {6, 6}, 1);
  const Shape upper = rectangle({0, 0}, {6, 6}, 3, 0, 0, 0.5f, 1);
  for (const Vec3& v : upper.mesh.vertices) twice.mesh.vertices.push_back(v);
  for (const Triangle& t : upper.mesh.triangles)
    twice.mesh.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
  twice.uv.insert(twice.uv.end(), upper.uv.begin(), upper.uv.end());
  EXPECT_TRUE(has(warnings(twice), "50 % of the texels belong to several triangles"));
  EXPECT_EQ(warnings(twice, {{"uv", "atlas"}, {"padding", "1"}}), "");
  EXPECT_TRUE(has(warnings(twice, {{"uv", "atlas"}}), "padding reaches only 1 of 16 pixels"));

  EXPECT_TRUE(has(warnings(rectangle({0, 0}, {6, 6}, 1, 1, 0, 2, 1)), "2 of 2 triangles leave the texture"));
  Shape flat = rectangle({0, 0}, {6, 6}, 1);
  flat.mesh.triangles.push_back({0, 1, 1});
  flat.uv.push_back(flat.uv[0]);
  EXPECT_TRUE(has(warnings(flat), "1 of 3 triangles have no area and are skipped"));
  EXPECT_TRUE(has(warnings(rectangle({0, 0}, {900, 900}, 1)), "150 periods of the solid (6 mm)"));
  EXPECT_TRUE(has(warnings(rectangle({0, 0}, {0.2, 0.2}, 1)), "1000 for meters"));
  EXPECT_EQ(warnings(rectangle({0, 0}, {0.02, 0.02}, 1), {{"scale", "300"}}), "");
}

TEST(Bake, WarnsOfWhatAVolumeDoesNotShow) {
  Volume volume = waves(true, true);
  const Value mesh = Value::of(only(rectangle({0, 0}, {6, 6}, 1)));
  const auto warnings = [&](std::multimap<std::string, Value> inputs, Settings settings = {}) {
    settings.emplace("resolution", "64");
    inputs.emplace("mesh", mesh);
    inputs.emplace("volume", Value::of(volume));
    return test::run_node("Bake", inputs, settings).warnings;
  };
  EXPECT_TRUE(warnings({}, {{"roughness", "[0.1]"}}).empty());
  auto voids = openvdb::FloatGrid::create(0);
  voids->setName("void");
  voids->setTransform(voxel_transform(1));
  volume.grids.push_back(voids);
  const auto all = warnings({{"detail", Value::of(grain())}}, {{"roughness", "[0.1, 0.2]"}});
  ASSERT_EQ(all.size(), 3u);
  EXPECT_NE(all[0].find("voids"), std::string::npos);
  EXPECT_NE(all[1].find("detail"), std::string::npos);
  EXPECT_NE(all[2].find("roughness has 2 values"), std::string::npos);
}

// Much smaller texels than the photograph's pixels, as on a mesh in meters, would be blurred over most of the
// texture.
TEST(Bake, RefusesABlurOfManyTexels) {
  const BakedSolid s = balls_on_a_lattice();
  Detail detail = grain();
  detail.softness = 3;  // 0.3 mm
  const auto inputs = inputs_of(rectangle({0, 0}, {6, 6}, 1), s, &detail);
  const auto refused = [](const char* type, const std::multimap<std::string, Value>& given,
                          const Settings& settings) -> std::string {
    try {
      test::run_node(type, given, settings);
    } catch (const Error& e) {
      return e.diagnostic().code + " " + e.diagnostic().parameter;
    }
    return "";
  };
  EXPECT_EQ(refused("Bake", inputs, {{"resolution", "64"}}), "");
  EXPECT_EQ(refused("Bake", inputs, {{"resolution", "64"}, {"scale", "0.01"}}), "bad-value scale");
  detail.softness = 200;
  EXPECT_EQ(refused("TextureSet",
                    {{"particles", Value::of(s.particles)},
                     {"shapes", Value::of(s.shapes)},
                     {"detail", Value::of(detail)}},
                    {{"resolution", "64"}}),
            "bad-value resolution");
}

// Coordinates from 1 to 2 are those from 0 to 1, and a quad may lie across the texture's edge.
TEST(Bake, CoordinatesOutsideAreWrapped) {
  const BakedSolid s = balls_on_a_lattice();
  const Settings settings = {{"resolution", "120"}, {"padding", "0"}};
  const Image in = bake_of(rectangle({0, 0}, {12, 12}, 1.4), s, settings).output<Image>("id");
  const Image out = bake_of(rectangle({0, 0}, {12, 12}, 1.4, 3, -2, 4, -1), s, settings).output<Image>("id");
  const Image across =
      bake_of(rectangle({0, 0}, {12, 12}, 1.4, 0.5f, 0, 1.5f, 1), s, settings).output<Image>("id");
  EXPECT_EQ(in.pixels, out.pixels);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 120; ++x) ASSERT_EQ(across.at((x + 60) % 120, y), in.at(x, y));
}

TEST(Bake, RefusesWhatItCannotShow) {
  const BakedSolid s = balls_on_a_lattice();
  const Shape plane = rectangle({0, 0}, {6, 6}, 1);
  const auto code = [](const std::multimap<std::string, Value>& inputs, Settings settings = {}) {
    settings.emplace("resolution", "64");
    return test::code_of([&] { test::run_node("Bake", inputs, settings); });
  };
  const Value mesh = Value::of(only(plane));
  EXPECT_EQ(code({{"mesh", mesh}}), "missing-input");
  EXPECT_EQ(code({{"mesh", mesh}, {"volume", Value::of(waves(false, true))}}), "not-periodic");
  EXPECT_EQ(code({{"mesh", mesh}, {"volume", Value::of(waves(true, false))}}, {{"relief", "1"}}),
            "no-such-grid");
  EXPECT_EQ(code({{"mesh", mesh}, {"volume", Value::of(waves(true, true))}, {"shapes", Value::of(s.shapes)}}),
            "two-sources");
  Shape bare = plane;
  bare.uv.clear();
  EXPECT_EQ(code(inputs_of(bare, s), {{"uv", "mesh"}}), "no-uv");
  Shapes two = only(plane);
  two.shapes.push_back(plane);
  EXPECT_EQ(
      code(
          {{"mesh", Value::of(two)}, {"particles", Value::of(s.particles)}, {"shapes", Value::of(s.shapes)}}),
      "one-shape-only");
  EXPECT_EQ(code(inputs_of(rectangle({0, 0}, {6, 6}, 1, 0, 0, 70, 1), s)), "bad-uv");
  EXPECT_EQ(code(inputs_of(rectangle({0, 0}, {6, 6}, 1, -60, -60, 60, 60), s)), "bad-uv");
  EXPECT_EQ(code(inputs_of(rectangle({0, 0}, {6, 6}, 1, 0, 0, 0.001f, 0.001f), s)), "bad-mesh");
  EXPECT_EQ(code(inputs_of(plane, s), {{"relief", "4"}}), "bad-value");
  Shape crumbs;
  for (int i = 0; i < 1200; ++i) {
    for (const Vec3& v : plane.mesh.vertices) crumbs.mesh.vertices.emplace_back(v + Vec3(0, 0, i));
    crumbs.mesh.triangles.push_back({4 * i, 4 * i + 1, 4 * i + 2});
  }
  EXPECT_EQ(code(inputs_of(crumbs, s)), "too-many-charts");

  ComputeRequest request;
  request.type = test::all_nodes().find("Bake");
  for (auto& [port, value] : inputs_of(plane, s)) request.inputs[port] = {value};
  request.parameters = effective_parameters(*request.type, {{"resolution", std::int64_t{16384}}});
  request.memory = std::uint64_t{8} << 30;
  EXPECT_EQ(test::code_of([&] { compute_node(std::move(request)); }), "too-large");
}

// The inputs of Export for maps and their mesh.
std::multimap<std::string, Value> exported(const test::NodeRun& maps) {
  std::multimap<std::string, Value> inputs;
  for (const auto& [name, value] : maps.outputs) inputs.emplace(name == "mesh" ? "shapes" : name, value);
  return inputs;
}

// Through the files that an artist has: .obj in, .glb out, and back.
TEST(Bake, MeshesKeepTheirCoordinatesInFiles) {
  const auto folder = test::temporary_folder();
  std::ofstream(folder / "quad.obj") << "v 0 0 1\nv 6 0 1\nv 6 6 1\nv 0 6 1\n"
                                        "vt 0.25 0\nvt 1 0\nvt 1 0.5\nvt 0.25 0.5\nf 1/1 2/2 3/3 -1/-1\n";
  const auto load = [&](const char* file, const char* scale) {
    return test::run_node("LoadMesh", {},
                          {{"path", (folder / file).string()}, {"surface", "true"}, {"scale", scale}})
        .output<Shapes>("shapes")
        .shapes.at(0);
  };
  const Shape quad = load("quad.obj", "1");
  ASSERT_EQ(quad.uv.size(), 2u);
  EXPECT_EQ(quad.surface_area, 36);
  for (std::size_t t = 0; t < 2; ++t)
    for (int k = 0; k < 3; ++k) {
      const Vec3& v = quad.mesh.vertices[quad.mesh.triangles[t][k]];
      EXPECT_FLOAT_EQ(quad.uv[t][k].x(), static_cast<float>(0.25 + v.x() / 8));
      EXPECT_FLOAT_EQ(quad.uv[t][k].y(), static_cast<float>(1 - v.y() / 12));  // downwards
    }
  const BakedSolid s = balls_on_a_lattice();
  const auto maps = bake_of(quad, s, {{"resolution", "64"}});
  EXPECT_TRUE(maps.warnings.empty());
  auto inputs = exported(maps);
  test::run_node("Export", inputs, {{"path", "quad.glb"}}, folder);
  const Shape again = load("quad.glb", "1");
  ASSERT_EQ(again.uv.size(), 2u);
  for (std::size_t t = 0; t < 2; ++t)
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT((again.uv[t][k] - quad.uv[t][k]).norm(), 1e-6f);
      EXPECT_LT(
          (again.mesh.vertices[again.mesh.triangles[t][k]] - quad.mesh.vertices[quad.mesh.triangles[t][k]])
              .norm(),
          1e-5);
    }
  Shape bare = quad;
  bare.uv.clear();
  inputs.erase("shapes");
  inputs.emplace("shapes", Value::of(only(bare)));
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Export", inputs, {{"path", "bare.glb"}}, folder);
            }),
            "no-uv");
}

TEST(Bake, MeshesWithMapsAreValidGltf) {
  const auto check = test::npm_check("gltf_check");
  if (check.empty()) GTEST_SKIP() << "node and npm are not installed, or cannot install the validator";
  const auto folder = test::temporary_folder();
  const auto maps =
      bake_of(rectangle({0, 0}, {6, 6}, 1, 0.25f, 0.5f, 1, 1), balls_on_a_lattice(), {{"resolution", "64"}});
  test::run_node("Export", exported(maps), {{"path", "quad.glb"}}, folder);
  const auto report = test::run_npm_check(check, folder / "quad.glb");
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["errors"], 0) << report["messages"].dump(1);
  // Readers derive the tangents of a mesh from its texture coordinates, as glTF prescribes.
  for (const auto& message : report["messages"])
    EXPECT_EQ(message.get<std::string>().rfind("MESH_PRIMITIVE_GENERATED_TANGENT_SPACE", 0), 0u) << message;
}

}  // namespace
}  // namespace terrazzo

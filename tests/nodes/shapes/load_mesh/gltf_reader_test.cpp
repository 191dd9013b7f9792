// glTF files: round trips, transforms, and files that lie.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/export/formats/gltf.h"
#include "nodes/shapes/load_mesh/read_mesh.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace load_mesh;
namespace fs = std::filesystem;
using nlohmann::json;

// A tetrahedron with corners at 0 and at 1 m on each axis; four floats of three, then twelve bytes of
// indices.
json tetrahedron_gltf() {
  return json::parse(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
                 {"bufferView":1,"componentType":5121,"count":12,"type":"SCALAR"}],
    "bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":12}],
    "buffers":[{"byteLength":60,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAIBAAEDAAMCAQID"}]})");
}

class GltfMesh : public ::testing::Test {
 protected:
  fs::path written(const std::string& text, const std::string& name = "a.gltf") {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }
  Shape loaded(const json& j, const std::map<std::string, std::string>& more = {}) {
    std::map<std::string, std::string> parameters = {{"path", written(j.dump()).string()}};
    parameters.insert(more.begin(), more.end());
    return test::run_node("LoadMesh", {}, parameters).output<Shapes>("shapes").shapes.at(0);
  }
  std::string code(const json& j) {
    return test::code_of([&] { read_mesh(written(j.dump())); });
  }
  fs::path folder = test::temporary_folder();
};

TEST_F(GltfMesh, MetersBecomeMillimetersAndYBecomesZ) {
  const auto soup = read_mesh(written(tetrahedron_gltf().dump()));
  ASSERT_EQ(soup.vertices.size(), 4u);
  EXPECT_EQ(soup.vertices[1], Vec3(1000, 0, 0));
  EXPECT_EQ(soup.vertices[2], Vec3(0, 0, 1000));
  EXPECT_EQ(soup.vertices[3], Vec3(0, -1000, 0));
  EXPECT_NEAR(loaded(tetrahedron_gltf()).volume, 1e9 / 6, 1);
  EXPECT_NEAR(loaded(tetrahedron_gltf(), {{"scale", "0.001"}}).volume, 1.0 / 6, 1e-9);
}

TEST_F(GltfMesh, NodesInstancesAndMirrorsAreApplied) {
  json j = tetrahedron_gltf();
  // A child in a mirrored parent; the matrix of the parent is column by column.
  j["nodes"] = json::parse(R"([{"children":[1],"matrix":[-2,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]},
                               {"mesh":0,"translation":[1,0,0],"rotation":[0,0,0.70710678,0.70710678],"scale":[1,3,1]}])");
  const auto soup = read_mesh(written(j.dump()));
  // (0, 1, 0): scaled to (0, 3, 0), turned to (−3, 0, 0), moved to (−2, 0, 0), then (4 + 5, 6, 7); y becomes
  // z.
  EXPECT_LT((soup.vertices[2] - Vec3(9000, -7000, 6000)).norm(), 0.01);
  EXPECT_NEAR(loaded(j).volume, 6 * 1e9 / 6, 1e3);  // not inside out

  json i = tetrahedron_gltf();
  i["extensionsUsed"] = i["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  i["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", 2}};
  // The corners again, twice as far away from each other: four bodies.
  i["accessors"].push_back({{"bufferView", 0}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
  i["nodes"][0]["scale"] = {0.5, 0.5, 0.5};
  const auto four = read_mesh(written(i.dump()));
  EXPECT_EQ(four.vertices.size(), 16u);
  EXPECT_LT((four.vertices[4] - Vec3(500, 0, 0)).norm(), 1e-3);
}

TEST_F(GltfMesh, StripsFansAndUnindexedTrianglesAreRead) {
  json j = tetrahedron_gltf();
  auto& primitive = j["meshes"][0]["primitives"][0];
  primitive["mode"] = 6;  // a fan around the first index
  EXPECT_EQ(read_mesh(written(j.dump())).polygons.front(), (std::vector<int>{0, 2, 1}));
  primitive["mode"] = 5;
  EXPECT_EQ(read_mesh(written(j.dump())).polygons.front(), (std::vector<int>{0, 2, 1}));
  primitive.erase("mode");
  primitive.erase("indices");
  EXPECT_EQ(code(j), "bad-mesh");  // four corners
  j["accessors"][0]["count"] = 3;
  EXPECT_EQ(read_mesh(written(j.dump())).polygons, (std::vector<std::vector<int>>{{0, 1, 2}}));
}

TEST_F(GltfMesh, OurOwnFilesComeBack) {
  Shapes one;
  one.shapes = {test::tetrahedron("t", true)};
  exporting::write_glb(folder / "s.glb", one);
  const auto back = test::run_node("LoadMesh", {}, {{"path", (folder / "s.glb").string()}});
  const Shape& s = back.output<Shapes>("shapes").shapes.at(0);
  EXPECT_NEAR(s.volume, 8.0 / 3, 1e-6);
  ASSERT_EQ(s.mesh.vertices.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((s.mesh.vertices[i] - one.shapes[0].mesh.vertices[i]).norm(), 1e-6);

  const Particles p = test::some_particles(20);
  double volume = 0;
  for (const double scale : p.scale) volume += 8.0 / 3 * scale * scale * scale;
  for (const auto instancing : {exporting::Instancing::Extension, exporting::Instancing::Nodes}) {
    exporting::write_glb(folder / "p.glb", p, test::two_shapes(), {}, {}, instancing);
    const auto all = test::run_node("LoadMesh", {}, {{"path", (folder / "p.glb").string()}});
    ASSERT_EQ(all.output<Shapes>("shapes").shapes.size(), p.scale.size());
    double sum = 0;
    for (const Shape& s : all.output<Shapes>("shapes").shapes) sum += s.volume;
    EXPECT_NEAR(sum, volume, 1e-3 * volume);
  }
}

TEST_F(GltfMesh, LiesAreErrors) {
  const auto changed = [&](const std::string& pointer, const json& value) {
    json j = tetrahedron_gltf();
    j[json::json_pointer(pointer)] = value;
    return code(j);
  };
  ASSERT_EQ(code(tetrahedron_gltf()), "");
  for (const json& huge : {json(5), json(1e9), json(4294967295u), json(18446744073709551615u), json(-1)})
    EXPECT_NE(changed("/accessors/0/count", huge), "") << huge;
  EXPECT_EQ(changed("/accessors/0/type", "VEC4"), "bad-mesh");
  EXPECT_EQ(changed("/accessors/0/componentType", 5130), "bad-mesh");
  EXPECT_NE(changed("/accessors/0/bufferView", 9), "");
  EXPECT_NE(changed("/accessors/0/byteOffset", 44), "");
  EXPECT_EQ(changed("/accessors/1/componentType", 5126), "bad-mesh");
  EXPECT_NE(changed("/bufferViews/0/byteOffset", 4294967290u), "");
  EXPECT_NE(changed("/bufferViews/0/byteLength", 1e15), "");
  EXPECT_NE(changed("/bufferViews/0/buffer", 7), "");
  EXPECT_NE(changed("/meshes/0/primitives/0/indices", 12), "");
  EXPECT_EQ(changed("/meshes/0/primitives/0/attributes/POSITION", 12), "bad-mesh");
  EXPECT_EQ(changed("/meshes/0/primitives/0/mode", 99), "bad-mesh");
  EXPECT_EQ(changed("/nodes/0/mesh", 3), "bad-mesh");
  EXPECT_EQ(changed("/nodes/0/children", {0}), "bad-mesh");
  EXPECT_EQ(changed("/nodes/0/children", {-4}), "bad-mesh");
  EXPECT_EQ(changed("/nodes/0/matrix", {1, 2}), "bad-mesh");
  EXPECT_EQ(changed("/nodes/0/rotation", {0, 0, 0, 0}), "bad-mesh");
  EXPECT_EQ(changed("/scenes/0/nodes/0", 8), "bad-mesh");
  EXPECT_EQ(changed("/scene", 2), "bad-mesh");
  EXPECT_EQ(changed("/extensionsRequired", {"KHR_draco_mesh_compression"}), "unreadable-mesh");
  EXPECT_EQ(
      changed(
          "/accessors/0/sparse",
          json::parse(
              R"({"count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":0}})")),
      "unreadable-mesh");
  // An index beyond the vertices, and a coordinate that is not a number.
  EXPECT_EQ(changed("/accessors/0/count", 3), "bad-mesh");
  EXPECT_EQ(changed("/buffers/0/uri",
                    "data:application/"
                    "octet-stream;base64,AADAfwAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/"
                    "AAIBAAEDAAMCAQID"),
            "bad-mesh");
  EXPECT_NE(changed("/buffers/0/uri", "data:application/octet-stream;base64,AAAA"), "");
  // Deeply nested values would exhaust the stack.
  EXPECT_EQ(test::code_of([&] {
              read_mesh(written(R"({"asset":{"version":"2.0"},"extras":)" + std::string(100000, '[') +
                                std::string(100000, ']') + "}"));
            }),
            "unreadable-mesh");
}

TEST_F(GltfMesh, OnlySurfacesReadTextureCoordinates) {
  const auto surface = [&](const json& j) {
    return read_mesh(written(j.dump()), {}, TextureCoordinates::Read);
  };
  json j = tetrahedron_gltf();
  json& primitives = j["meshes"][0]["primitives"];
  primitives[0]["attributes"]["TEXCOORD_0"] = 12;  // no such accessor
  EXPECT_EQ(code(j), "");
  EXPECT_EQ(test::code_of([&] { surface(j); }), "bad-mesh");

  primitives[0]["attributes"]["TEXCOORD_0"] = 2;  // the first floats of the positions
  j["accessors"].push_back({{"bufferView", 0}, {"componentType", 5126}, {"count", 4}, {"type", "VEC2"}});
  EXPECT_EQ(surface(j).uv.size(), 4u);
  EXPECT_EQ(surface(j).without_uv, 0u);
  EXPECT_TRUE(read_mesh(written(j.dump())).uv.empty());

  primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"indices", 1}});
  const auto soup = surface(j);
  EXPECT_EQ(soup.polygons.size(), 8u);
  EXPECT_EQ(soup.without_uv, 4u);
  EXPECT_TRUE(soup.uv.empty());
}

TEST_F(GltfMesh, NoOtherFileIsOpened) {
  std::ofstream(folder / "secret.bin", std::ios::binary) << std::string(60, '\0');
  for (const std::string path :
       {"secret.bin", "../secret.bin", "/etc/passwd", "file:///etc/passwd", "$(touch x)"}) {
    json j = tetrahedron_gltf();
    j["buffers"][0]["uri"] = path;
    EXPECT_EQ(code(j), "unreadable-mesh") << path;
  }
  json j = tetrahedron_gltf();
  j["images"] = {{{"uri", "/etc/passwd"}}};
  EXPECT_EQ(code(j), "");
}

TEST_F(GltfMesh, ACutFileIsAnError) {
  Shapes one;
  one.shapes = {test::tetrahedron("t", false)};
  exporting::write_glb(folder / "s.glb", one);
  const std::string whole = test::content_of(folder / "s.glb");
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_NE(test::code_of([&] { read_mesh(written(whole.substr(0, size), "cut.glb")); }), "") << size;
  Reading little;
  little.memory = 1000;
  EXPECT_EQ(test::code_of([&] { read_mesh(folder / "s.glb", little); }), "too-large");
}

}  // namespace
}  // namespace terrazzo

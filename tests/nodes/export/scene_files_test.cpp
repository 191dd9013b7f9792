// Scenes for renderers: glTF with one node per particle, and OpenUSD.
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <regex>
#include <set>

#include "nodes/common/io/provenance.h"
#include "nodes/common/texture/color.h"
#include "nodes/export/color_classes.h"
#include "nodes/export/formats/gltf.h"
#include "nodes/export/formats/usda_file.h"
#include "tests/nodes/export/export_support.h"
#include "tests/nodes/export/voxel_support.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

TEST(ColorClasses, AreExactOrWithinOneStep) {
  std::vector<Vec3f> colors;
  for (std::size_t i = 0; i < 2000; ++i) {
    Random r(4, 4, i);
    colors.emplace_back(float(r.uniform()), float(r.uniform()), float(r.uniform()));
  }
  for (const int most : {1, 2, 8, 27, 64, 500, 2000}) {
    const ColorClasses c = color_classes(colors, most);
    ASSERT_EQ(c.of.size(), colors.size());
    EXPECT_LE(c.color.size(), std::size_t(most));
    // n steps per channel have up to n³ cells, so the finest that fits has at least the cube root.
    const float step = 1.0f / std::floor(std::cbrt(float(most)) + 1e-3f);
    for (std::size_t i = 0; i < colors.size(); ++i) {
      const Vec3f d = linear_to_srgb(colors[i]) - linear_to_srgb(c.color.at(c.of[i]));
      EXPECT_LE(d.cwiseAbs().maxCoeff(), most == 2000 ? 0 : step + 1e-5f);
    }
  }
  EXPECT_EQ(color_classes({{0.1f, 0.2f, 0.3f}, {1, 1, 1}, {0.1f, 0.2f, 0.3f}}, 2).of,
            (std::vector<int>{0, 1, 0}));
  EXPECT_TRUE(color_classes({}, 3).color.empty());
}

TEST(ExportGltfNodes, EveryParticleIsANode) {
  Particles p = test::some_particles(200);
  p.voids.assign(200, 0);
  p.voids[7] = 1;
  const Shapes shapes = test::two_shapes();
  const fs::path file = test::temporary_folder() / "p.glb";
  write_glb(file, p, shapes, {}, {}, Instancing::Nodes, 16);
  tinygltf::Model m;
  tinygltf::TinyGLTF reader;
  std::string error, warning;
  ASSERT_TRUE(reader.LoadBinaryFromFile(&m, &error, &warning, file.string())) << error;
  EXPECT_TRUE(m.extensionsUsed.empty());
  EXPECT_LE(m.materials.size(), 16u);
  EXPECT_LE(m.meshes.size(), 2 * m.materials.size());
  ASSERT_EQ(m.scenes.at(0).nodes.size(), 1u);
  const auto& all = m.nodes.at(m.scenes[0].nodes[0]);
  EXPECT_EQ(all.name, "particles");
  std::set<int> seen, positions;
  for (const int child : all.children) {
    const auto& node = m.nodes.at(child);
    const int i = node.extras.Get("id").GetNumberAsInt();
    EXPECT_TRUE(seen.insert(i).second);
    EXPECT_EQ(node.name, shapes.shapes[p.shape[i]].name + "_" + std::to_string(i));
    EXPECT_EQ(node.extras.Get("class").GetNumberAsInt(), p.cls[i]);
    EXPECT_FLOAT_EQ(float(node.extras.Get("color").Get(1).GetNumberAsDouble()), p.color[i].y());
    EXPECT_NEAR(node.translation.at(0), p.position[i].x() * 0.001, 1e-12);
    EXPECT_NEAR(node.translation.at(1), p.position[i].z() * 0.001, 1e-12);
    EXPECT_NEAR(node.translation.at(2), -p.position[i].y() * 0.001, 1e-12);
    EXPECT_EQ(node.scale.at(2), p.scale[i]);
    const auto& primitive = m.meshes.at(node.mesh).primitives.at(0);
    positions.insert(primitive.attributes.at("POSITION"));
    const auto& factor = m.materials.at(primitive.material).pbrMetallicRoughness.baseColorFactor;
    const Vec3f material = Eigen::Vector3d(factor[0], factor[1], factor[2]).cast<float>();
    EXPECT_LT((linear_to_srgb(material) - linear_to_srgb(p.color[i])).cwiseAbs().maxCoeff(), 0.51f);
  }
  EXPECT_EQ(seen.size(), 199u);
  EXPECT_EQ(seen.count(7), 0u);
  EXPECT_EQ(positions.size(), 2u);  // meshes of a shape share its vertices
}

// The numbers of the array that follows `declaration`.
std::vector<double> usda_array(const std::string& text, const std::string& declaration) {
  const auto at = text.find(declaration + " = [");
  EXPECT_NE(at, std::string::npos) << declaration;
  if (at == std::string::npos) return {};
  const auto begin = at + declaration.size() + 4, end = text.find(']', begin);
  std::string inside = text.substr(begin, end - begin);
  for (char& c : inside)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  std::istringstream in(inside);
  std::vector<double> numbers;
  for (std::string word; in >> word;) numbers.push_back(std::stod(word));
  return numbers;
}

TEST(ExportUsda, InstancesAreTheParticles) {
  Particles p = test::some_particles(150);
  p.voids.assign(150, 0);
  p.voids[0] = p.voids[149] = 1;
  Shapes shapes = test::two_shapes();
  shapes.shapes[0].name = "1 faceted \"stone\"";  // not an identifier
  shapes.shapes[1].name = "é";
  const fs::path file = test::temporary_folder() / "p.usda";
  write_usda(file, p, shapes, {}, R"({"graph": "a \"b\".yaml"})");
  const std::string text = test::content_of(file);
  EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
  for (const char* words :
       {"metersPerUnit = 0.001", "upAxis = \"Z\"", "defaultPrim = \"Aggregate\"",
        "subdivisionScheme = \"none\"", "</Aggregate/Particles/Prototypes/_1_faceted__stone_>",
        "def Mesh \"_1_faceted__stone_\"", R"(string provenance = "{\"graph\": \"a \\\"b\\\".yaml\"}")",
        R"(string name = "1 faceted \"stone\"")"})
    EXPECT_NE(text.find(words), std::string::npos) << words;
  EXPECT_EQ(text.find("OpenVDBAsset"), std::string::npos);
  EXPECT_EQ(read_provenance(file), R"({"graph": "a \"b\".yaml"})");

  const auto prototype = usda_array(text, "int[] protoIndices"), ids = usda_array(text, "int64[] ids"),
             position = usda_array(text, "point3f[] positions"),
             orientation = usda_array(text, "quath[] orientations"),
             scale = usda_array(text, "float3[] scales"),
             color = usda_array(text, "color3f[] primvars:displayColor"),
             cls = usda_array(text, "int[] primvars:class"), size = usda_array(text, "float[] primvars:size"),
             extent = usda_array(text, "float3[] extent");
  ASSERT_EQ(ids.size(), 148u);
  ASSERT_EQ(prototype.size(), 148u);
  ASSERT_EQ(position.size(), 3 * 148u);
  ASSERT_EQ(orientation.size(), 4 * 148u);
  ASSERT_EQ(scale.size(), 3 * 148u);
  ASSERT_EQ(color.size(), 3 * 148u);
  ASSERT_EQ(cls.size(), 148u);
  ASSERT_EQ(size.size(), 148u);
  ASSERT_EQ(extent.size(), 6u);
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const auto i = static_cast<std::size_t>(ids[k]);
    EXPECT_EQ(i, k + 1);
    EXPECT_EQ(prototype[k], p.shape[i]);
    EXPECT_EQ(cls[k], p.cls[i]);
    const Quat q(orientation[4 * k], orientation[4 * k + 1], orientation[4 * k + 2], orientation[4 * k + 3]);
    EXPECT_LT(q.normalized().angularDistance(p.orientation[i]), 0.001);  // 0.06 degrees
    for (int c = 0; c < 3; ++c) {
      EXPECT_FLOAT_EQ(float(position[3 * k + c]), float(p.position[i][c]));
      EXPECT_FLOAT_EQ(float(scale[3 * k + c]), float(p.scale[i]));
      EXPECT_FLOAT_EQ(float(color[3 * k + c]), p.color[i][c]);
    }
    for (const Vec3& v : shapes.shapes[p.shape[i]].mesh.vertices)
      box.extend(p.position[i] + p.orientation[i] * (p.scale[i] * v));
  }
  for (int c = 0; c < 3; ++c) {  // the extent contains every vertex, and little more
    EXPECT_LE(extent[c], box.min()[c] + 1e-5);
    EXPECT_GE(extent[3 + c], box.max()[c] - 1e-5);
    EXPECT_GT(extent[c], -2 * std::sqrt(3.0) - 1e-5);
    EXPECT_LT(extent[3 + c], p.box[c] + 2 * std::sqrt(3.0) + 1e-5);
  }
  const auto counts = usda_array(text, "int[] faceVertexCounts"),
             indices = usda_array(text, "int[] faceVertexIndices"),
             points = usda_array(text, "point3f[] points");
  EXPECT_EQ(counts.size(), 4u);
  EXPECT_EQ(indices.size(), 12u);
  EXPECT_EQ(points.size(), 12u);
  for (const double i : indices) EXPECT_LT(i, 4);
}

TEST(ExportUsda, NamesTheVolumeBesideIt) {
  const fs::path out = test::temporary_folder();
  test::run_node("Export",
                 {{"particles", Value::of(test::some_particles(5))},
                  {"shapes", Value::of(test::two_shapes())},
                  {"volume", Value::of(test::formula_volume())}},
                 {{"path", "sub/scene one.usda"}}, out);
  const std::string text = test::content_of(out / "sub/scene one.usda");
  EXPECT_NE(text.find("asset filePath = @./scene one.vdb@"), std::string::npos);
  EXPECT_NE(text.find("token fieldName = \"Cd\""), std::string::npos);
  EXPECT_TRUE(fs::exists(out / "sub/scene one.vdb"));
}

TEST(ExportUsda, RefusesWhatCannotBeShown) {
  const fs::path out = test::temporary_folder();
  const auto code = [&](const Particles& p, const Shapes& s) {
    const Volume v = test::formula_volume();
    return test::code_of([&] {
      test::run_node("Export",
                     {{"particles", Value::of(p)}, {"shapes", Value::of(s)}, {"volume", Value::of(v)}},
                     {{"path", "a.usda"}}, out);
    });
  };
  EXPECT_EQ(code(Particles(), test::two_shapes()), "no-particles");
  EXPECT_EQ(code(test::some_particles(3), Shapes()), "no-such-shape");
  Particles p = test::some_particles(3);
  p.scale[1] = std::nan("");
  EXPECT_EQ(code(p, test::two_shapes()), "bad-number");
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Export", {{"shapes", Value::of(Shapes())}}, {{"path", "a.usda"}}, out);
            }),
            "no-shapes");
  EXPECT_EQ(test::files_in(out), 0u);
}

TEST(ExportUsda, ShapesAloneShowTheirColors) {
  const fs::path out = test::temporary_folder();
  Shapes shapes;
  shapes.shapes = {test::tetrahedron("a body", true)};
  for (int i = 0; i < 4; ++i) shapes.shapes[0].color.push_back(Vec3f(0.25f * float(i), 0.5f, 1));
  test::run_node("Export", {{"shapes", Value::of(shapes)}}, {{"path", "a.usda"}}, out);
  const std::string text = test::content_of(out / "a.usda");
  EXPECT_NE(text.find("def Mesh \"a_body\""), std::string::npos);
  const auto color = usda_array(text, "color3f[] primvars:displayColor");
  ASSERT_EQ(color.size(), 12u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(color[3 * i], 0.25 * double(i));
}

}  // namespace
}  // namespace terrazzo

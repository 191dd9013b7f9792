#include "nodes/export/formats/gltf.h"

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cstring>

#include "nodes/data/image.h"
#include "tests/nodes/export/export_support.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;

tinygltf::Model load(const fs::path& file) {
  tinygltf::Model model;
  tinygltf::TinyGLTF reader;
  std::string error, warning;
  EXPECT_TRUE(reader.LoadBinaryFromFile(&model, &error, &warning, file.string())) << error;
  EXPECT_EQ(warning, "");
  return model;
}

std::vector<float> floats(const tinygltf::Model& m, int accessor) {
  const auto& a = m.accessors.at(accessor);
  const auto& v = m.bufferViews.at(a.bufferView);
  EXPECT_EQ(a.componentType, TINYGLTF_COMPONENT_TYPE_FLOAT);
  const std::size_t n = a.count * tinygltf::GetNumComponentsInType(a.type);
  std::vector<float> out(n);
  std::memcpy(out.data(), m.buffers[v.buffer].data.data() + v.byteOffset + a.byteOffset, n * sizeof(float));
  return out;
}

std::vector<float> instance_floats(const tinygltf::Model& m, const tinygltf::Node& node,
                                   const std::string& name) {
  const auto& e = node.extensions.at("EXT_mesh_gpu_instancing");
  return floats(m, e.Get("attributes").Get(name).GetNumberAsInt());
}

Vec3 turned(const Vec3& v) { return {v.x(), v.z(), -v.y()}; }

TEST(ExportGltf, InstancesAreTheParticles) {
  const Particles p = test::some_particles(300);
  const fs::path file = test::temporary_folder() / "p.glb";
  write_glb(file, p, test::two_shapes());
  const auto m = load(file);
  EXPECT_EQ(m.asset.generator, "Terrazzo");
  EXPECT_EQ(m.extensionsUsed, std::vector<std::string>{"EXT_mesh_gpu_instancing"});
  ASSERT_EQ(m.meshes.size(), 2u);  // without the unused shape
  ASSERT_EQ(m.nodes.size(), 2u);
  EXPECT_EQ(m.scenes.at(0).nodes.size(), 2u);

  std::vector<bool> seen(p.count());
  for (const auto& node : m.nodes) {
    const auto translation = instance_floats(m, node, "TRANSLATION"),
               rotation = instance_floats(m, node, "ROTATION"), scale = instance_floats(m, node, "SCALE"),
               color = instance_floats(m, node, "_COLOR_0"), id = instance_floats(m, node, "_ID");
    ASSERT_EQ(translation.size(), 3 * id.size());
    ASSERT_EQ(rotation.size(), 4 * id.size());
    const std::string name = m.meshes[node.mesh].name;
    for (std::size_t k = 0; k < id.size(); ++k) {
      const auto i = static_cast<std::size_t>(id[k]);
      ASSERT_LT(i, p.count());
      EXPECT_FALSE(seen[i]);
      seen[i] = true;
      EXPECT_EQ(name, p.shape[i] == 0 ? "faceted" : "smooth");
      const Vec3 at = turned(p.position[i]) * 0.001;
      const Quat q(rotation[4 * k + 3], rotation[4 * k], rotation[4 * k + 1], rotation[4 * k + 2]);
      EXPECT_NEAR(q.norm(), 1, 1e-6);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(translation[3 * k + c], at[c], 1e-8);
        EXPECT_FLOAT_EQ(scale[3 * k + c], static_cast<float>(p.scale[i]));
        EXPECT_EQ(color[3 * k + c], p.color[i][c]);
      }
      // Rotating the world after the particle equals applying the written rotation to the rotated mesh.
      for (const Vec3& v : {Vec3(1, 0, 0), Vec3(0.3, -2, 1)})
        EXPECT_LT((turned(p.orientation[i] * v) - q * turned(v)).norm(), 1e-5);
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), 300);
}

TEST(ExportGltf, MeshesKeepHandednessAndShading) {
  const fs::path file = test::temporary_folder() / "p.glb";
  write_glb(file, test::some_particles(50), test::two_shapes());
  const auto m = load(file);
  for (const auto& mesh : m.meshes) {
    const auto& primitive = mesh.primitives.at(0);
    const auto position = floats(m, primitive.attributes.at("POSITION"));
    const auto normal = floats(m, primitive.attributes.at("NORMAL"));
    EXPECT_EQ(position.size(), mesh.name == "faceted" ? 36u : 12u);
    const auto& a = m.accessors.at(primitive.indices);
    ASSERT_EQ(a.count, 12u);
    ASSERT_EQ(a.componentType, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT);
    const auto* index = reinterpret_cast<const std::uint16_t*>(m.buffers[0].data.data() +
                                                               m.bufferViews[a.bufferView].byteOffset);
    double volume = 0;
    for (std::size_t t = 0; t < a.count; t += 3) {
      Eigen::Matrix3d corner;
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c) corner(c, k) = position[3 * index[t + k] + c];
      volume += corner.determinant() / 6;
      if (mesh.name != "faceted") continue;
      const Vec3 n = (corner.col(1) - corner.col(0)).cross(corner.col(2) - corner.col(0)).normalized();
      for (int k = 0; k < 3; ++k)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(normal[3 * index[t + k] + c], n[c], 1e-6);
    }
    EXPECT_NEAR(volume, 8.0 / 3 * 1e-9, 1e-14);  // m³; positive, so faces still point outward
    if (mesh.name == "smooth") {                 // by symmetry, normals point along the corners
      for (std::size_t i = 0; i < position.size(); ++i)
        EXPECT_NEAR(normal[i], position[i] / 0.001 / std::sqrt(3.0), 1e-5);
    }
  }
}

TEST(ExportGltf, RecordsWhatMadeIt) {
  const fs::path file = test::temporary_folder() / "p.glb";
  write_glb(
      file, test::some_particles(3), test::two_shapes(),
      R"({"graph": "a.yaml", "overrides": {"seed": 7, "big": 9007199254740991, "x": 0.5}, "keys": ["ab", true]})");
  const auto m = load(file);
  const auto& extras = m.asset.extras;
  EXPECT_EQ(extras.Get("graph").Get<std::string>(), "a.yaml");
  EXPECT_EQ(extras.Get("overrides").Get("seed").GetNumberAsInt(), 7);
  EXPECT_EQ(extras.Get("overrides").Get("big").GetNumberAsDouble(), 9007199254740991.0);
  EXPECT_EQ(extras.Get("overrides").Get("x").GetNumberAsDouble(), 0.5);
  EXPECT_EQ(extras.Get("keys").Get(0).Get<std::string>(), "ab");
}

TEST(ExportGltf, ShapesAloneStandSideBySide) {
  const fs::path file = test::temporary_folder() / "s.glb";
  write_glb(file, test::two_shapes());
  const auto m = load(file);
  ASSERT_EQ(m.nodes.size(), 3u);
  EXPECT_TRUE(m.extensionsUsed.empty());
  double end = -1;
  for (const auto& node : m.nodes) {  // each 2 mm wide, centered at its origin
    const double x = node.translation.empty() ? 0 : node.translation[0];
    EXPECT_GT(x - 0.001, end);
    end = x + 0.001;
  }
}

Shapes painted_shapes() {
  Shapes s;
  for (const bool smooth : {true, false}) {
    Shape t = test::tetrahedron(smooth ? "smooth" : "faceted", smooth);
    for (int i = 0; i < 4; ++i) t.color.push_back(Vec3f(0.25f * float(i), 0.5f, 1.5f));
    for (int i = 0; i < 4; ++i) {
      const float x = 0.25f * float(i);
      t.uv.push_back({Eigen::Vector2f(x, 0), Eigen::Vector2f(x + 0.2f, 0), Eigen::Vector2f(x, 1)});
    }
    s.shapes.push_back(t);
  }
  return s;
}

TEST(ExportGltf, ColorsOfVerticesStayWithTheirVertices) {
  const fs::path file = test::temporary_folder() / "c.glb";
  const Shapes shapes = painted_shapes();
  write_glb(file, shapes);
  const auto m = load(file);
  for (std::size_t s = 0; s < 2; ++s) {
    const auto& primitive = m.meshes.at(s).primitives.at(0);
    const auto position = floats(m, primitive.attributes.at("POSITION"));
    const auto color = floats(m, primitive.attributes.at("COLOR_0"));
    ASSERT_EQ(color.size(), position.size());
    for (std::size_t i = 0; i < position.size(); i += 3) {
      int found = 0;
      for (std::size_t v = 0; v < 4; ++v) {
        const Vec3 at = 0.001 * turned(shapes.shapes[s].mesh.vertices[v]);
        if ((at - Vec3(position[i], position[i + 1], position[i + 2])).norm() > 1e-9) continue;
        ++found;
        EXPECT_EQ(color[i], 0.25f * float(v));
        EXPECT_EQ(color[i + 2], 1);  // clamped to what glTF allows
      }
      EXPECT_EQ(found, 1);
    }
  }
}

TEST(ExportGltf, ATextureReplacesTheColors) {
  const fs::path out = test::temporary_folder();
  Image texture(4, 2, 1, 1);
  for (std::size_t i = 0; i < texture.pixels.size(); ++i)
    texture.pixels[i] = Vec3f(i == 5 ? 1.0f : 0.0f, 0.0f, 1.0f);
  const Shapes shapes = painted_shapes();
  test::run_node("Export", {{"shapes", Value::of(shapes)}, {"image", Value::of(texture)}},
                 {{"path", "t.glb"}}, out);
  const auto m = load(out / "t.glb");
  ASSERT_EQ(m.images.size(), 1u);
  EXPECT_EQ(m.images[0].width, 4);
  EXPECT_EQ(m.images[0].image.at(5 * static_cast<std::size_t>(m.images[0].component)), 255);
  EXPECT_EQ(m.images[0].image.at(0), 0);
  const auto& primitive = m.meshes.at(0).primitives.at(0);
  EXPECT_EQ(primitive.attributes.count("COLOR_0"), 0u);
  EXPECT_GE(m.materials.at(static_cast<std::size_t>(primitive.material))
                .pbrMetallicRoughness.baseColorTexture.index,
            0);
  const auto uv = floats(m, primitive.attributes.at("TEXCOORD_0"));
  ASSERT_EQ(uv.size(), 24u);
  for (std::size_t t = 0; t < 4; ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(uv[6 * t + 2 * k], shapes.shapes[0].uv[t][k].x());
      EXPECT_EQ(uv[6 * t + 2 * k + 1], shapes.shapes[0].uv[t][k].y());
    }
  const auto code = [&](const std::multimap<std::string, Value>& inputs) {
    return test::code_of([&] { test::run_node("Export", inputs, {{"path", "e.glb"}}, out); });
  };
  EXPECT_EQ(code({{"shapes", Value::of(test::two_shapes())}, {"image", Value::of(texture)}}), "no-uv");
  EXPECT_EQ(code({{"shapes", Value::of(shapes)},
                  {"particles", Value::of(test::some_particles(3))},
                  {"image", Value::of(texture)}}),
            "no-uv");
}

TEST(ExportGltf, TheSameParticlesGiveTheSameFile) {
  const fs::path folder = test::temporary_folder();
  write_glb(folder / "a.glb", test::some_particles(100), test::two_shapes(), R"({"a": 1})");
  write_glb(folder / "b.glb", test::some_particles(100), test::two_shapes(), R"({"a": 1})");
  EXPECT_EQ(test::content_of(folder / "a.glb"), test::content_of(folder / "b.glb"));
}

TEST(ExportGltf, RefusesWhatCannotBeShown) {
  const fs::path file = test::temporary_folder() / "p.glb";
  const auto code = [&](const Particles& p, const Shapes& s) {
    return test::code_of([&] { write_glb(file, p, s); });
  };
  const Shapes shapes = test::two_shapes();
  EXPECT_EQ(code(Particles(), shapes), "no-particles");
  EXPECT_EQ(code(test::some_particles(3), Shapes()), "no-such-shape");
  Particles p = test::some_particles(3);
  p.position[1].y() = std::nan("");
  EXPECT_EQ(code(p, shapes), "bad-number");
  p = test::some_particles(3);
  p.orientation[2].coeffs().setZero();
  EXPECT_EQ(code(p, shapes), "bad-number");
  Shapes broken = shapes;
  broken.shapes[0].mesh.triangles[0][1] = 99;
  EXPECT_EQ(code(test::some_particles(30), broken), "bad-mesh");
  broken = shapes;
  broken.shapes[1].mesh.vertices[0].x() = INFINITY;
  EXPECT_EQ(code(test::some_particles(30), broken), "bad-number");
}

}  // namespace
}  // namespace terrazzo

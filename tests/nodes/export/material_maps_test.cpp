// Texture maps as pictures, as MaterialX and in binary glTF.
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <pugixml.hpp>

#include "nodes/common/io/image_file.h"
#include "nodes/common/io/pictures/picture_codec.h"
#include "nodes/common/io/provenance.h"
#include "tests/support/code_of.h"
#include "tests/support/readers.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace fs = std::filesystem;

constexpr int kSide = 16;

Image gradient(const Vec3f& from, const Vec3f& to) {
  Image image(kSide, kSide, 1, 0.5);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = from + (to - from) * (static_cast<float>(i) / (kSide * kSide - 1));
  return image;
}

std::multimap<std::string, Value> some_maps() {
  return {{"base_color", Value::of(gradient(Vec3f(0, 0.1f, 0.2f), Vec3f(1, 0.5f, 0.3f)))},
          {"normal", Value::of(gradient(Vec3f(0.2f, 0.5f, 0.8f), Vec3f(0.8f, 0.4f, 0.9f)))},
          {"height", Value::of(gradient(Vec3f::Constant(-2.5f), Vec3f::Constant(4)))},
          {"roughness", Value::of(gradient(Vec3f::Zero(), Vec3f::Ones()))},
          {"occlusion", Value::of(gradient(Vec3f::Ones(), Vec3f::Constant(0.25f)))},
          {"id", Value::of(gradient(Vec3f::Zero(), Vec3f::Ones()))}};
}

// The stored numbers of a file, and its number of channels.
std::vector<float> stored(const fs::path& file, int channels, Sample sample) {
  const auto in = picture_codec().open(file, "", {{"oiio:UnassociatedAlpha", 1}});
  EXPECT_EQ(in->header().count(), channels) << file;
  EXPECT_EQ(in->header().sample, sample) << file;
  std::vector<float> values(std::size_t{kSide * kSide} * channels);
  EXPECT_TRUE(in->read(Sample::Float, values.data()));
  return values;
}

TEST(ExportMaps, MaterialXWritesTheMapsBesideIt) {
  const fs::path out = test::temporary_folder();
  const auto maps = some_maps();
  test::run_node("Export", maps, {{"path", "stone/material.mtlx"}}, out);
  const auto expect_raw = [&](const char* name, const char* file, int channels, Sample sample, float step) {
    const Image& image = maps.find(name)->second.as<Image>();
    const std::vector<float> values = stored(out / "stone" / file, channels, sample);
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_NEAR(values[i], image.pixels[i / channels][static_cast<int>(i) % channels], 0.5001f * step)
          << file;
  };
  expect_raw("normal", "normal.png", 3, Sample::UInt16, 1.0f / 65535);
  expect_raw("height", "height.exr", 1, Sample::Float, 0);
  expect_raw("roughness", "roughness.png", 1, Sample::UInt8, 1.0f / 255);
  expect_raw("occlusion", "occlusion.png", 1, Sample::UInt8, 1.0f / 255);
  expect_raw("id", "id.png", 3, Sample::UInt8, 1.0f / 255);
  const Image color = read_image(out / "stone" / "base_color.png");  // sRGB, decoded
  for (std::size_t i = 0; i < color.pixels.size(); ++i)
    EXPECT_LT((color.pixels[i] - maps.find("base_color")->second.as<Image>().pixels[i]).cwiseAbs().maxCoeff(),
              0.01f);

  pugi::xml_document xml;
  ASSERT_TRUE(xml.load_file((out / "stone" / "material.mtlx").c_str()));
  const auto root = xml.child("materialx");
  EXPECT_STREQ(root.attribute("version").value(), "1.38");
  std::map<std::string, std::string> files;
  for (const auto& image : root.child("nodegraph").children("tiledimage"))
    files[image.attribute("name").value()] = image.child("input").attribute("value").value();
  EXPECT_EQ(files, (std::map<std::string, std::string>{{"base_color_image", "base_color.png"},
                                                       {"normal_image", "normal.png"},
                                                       {"roughness_image", "roughness.png"}}));
  EXPECT_FALSE(read_provenance(out / "stone" / "material.mtlx").empty());
}

TEST(ExportMaps, MaterialXsOwnValidatorAcceptsBothSurfaces) {
  const fs::path check = test::npm_check("materialx_check");
  if (check.empty()) GTEST_SKIP() << "node and npm are not installed, or cannot install MaterialX";
  const fs::path out = test::temporary_folder();
  for (const char* shader : {"standard_surface", "open_pbr_surface"}) {
    const std::string name = std::string(shader) + ".mtlx";
    test::run_node("Export", some_maps(), {{"path", name}, {"shader", shader}}, out);
    const auto report = test::run_npm_check(check, out / name);
    ASSERT_TRUE(report.is_object());
    EXPECT_TRUE(report["valid"]) << report["message"];
    EXPECT_EQ(report["nodes"], (nlohmann::json{shader, "surfacematerial"}));
  }
}

TEST(ExportMaps, APlaneShowsThemInGltf) {
  const fs::path out = test::temporary_folder();
  const auto maps = some_maps();
  test::run_node("Export", maps, {{"path", "m.glb"}}, out);
  tinygltf::TinyGLTF reader;
  tinygltf::Model m;
  std::string error, warning;
  ASSERT_TRUE(reader.LoadBinaryFromFile(&m, &error, &warning, (out / "m.glb").string())) << error;
  ASSERT_EQ(m.materials.size(), 1u);
  const auto& material = m.materials[0];
  const auto picture = [&](int texture) -> const tinygltf::Image& {
    return m.images.at(m.textures.at(texture).source);
  };
  const tinygltf::Image& packed = picture(material.pbrMetallicRoughness.metallicRoughnessTexture.index);
  EXPECT_EQ(material.occlusionTexture.index, material.pbrMetallicRoughness.metallicRoughnessTexture.index);
  const std::size_t last = std::size_t{kSide * kSide - 1} * static_cast<std::size_t>(packed.component);
  EXPECT_EQ(packed.image.at(0), 255);  // occlusion
  EXPECT_EQ(packed.image.at(1), 0);    // roughness
  EXPECT_EQ(packed.image.at(2), 0);    // metalness
  EXPECT_EQ(packed.image.at(last), 64);
  EXPECT_EQ(packed.image.at(last + 1), 255);
  EXPECT_EQ(picture(material.normalTexture.index).image.at(2), 204);
  EXPECT_EQ(m.meshes.at(0).primitives.at(0).attributes.count("TANGENT"), 1u);
  const auto& position = m.accessors.at(m.meshes[0].primitives[0].attributes.at("POSITION"));
  EXPECT_NEAR(position.maxValues.at(0) - position.minValues.at(0), kSide * 0.5 * 0.001, 1e-9);

  const fs::path check = test::npm_check("gltf_check");
  if (check.empty())
    GTEST_SKIP() << "node and npm are not installed, or cannot install gltf-validator and three";
  const auto report = test::run_npm_check(check, out / "m.glb");
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["errors"], 0) << report["messages"].dump(1);
  EXPECT_EQ(report["warnings"], 0) << report["messages"].dump(1);
}

TEST(ExportMaps, ChannelsArePacked) {
  const fs::path out = test::temporary_folder();
  const auto maps = some_maps();
  const auto value = [&](const char* name, std::size_t i, int channel) {
    return std::clamp(maps.find(name)->second.as<Image>().pixels[i][channel], 0.0f, 1.0f);
  };
  test::run_node("Export", maps, {{"path", "orm.png"}, {"pack", "[occlusion, roughness, black]"}}, out);
  const auto orm = stored(out / "orm.png", 3, Sample::UInt8);
  test::run_node("Export", maps,
                 {{"path", "mask.tif"}, {"pack", "[normal.g, occlusion, white, 1-roughness]"}}, out);
  const auto mask = stored(out / "mask.tif", 4, Sample::UInt16);
  test::run_node("Export", maps, {{"path", "h.exr"}, {"pack", "[height, id.b]"}}, out);
  const auto height = stored(out / "h.exr", 2, Sample::Float);
  for (std::size_t i = 0; i < kSide * kSide; ++i) {
    ASSERT_NEAR(orm[3 * i], value("occlusion", i, 0), 0.51f / 255);
    ASSERT_NEAR(orm[3 * i + 1], value("roughness", i, 0), 0.51f / 255);
    ASSERT_EQ(orm[3 * i + 2], 0);
    ASSERT_NEAR(mask[4 * i + 3], 1 - value("roughness", i, 0), 0.51f / 65535);
    ASSERT_EQ(height[2 * i], maps.find("height")->second.as<Image>().pixels[i].x());
    ASSERT_EQ(height[2 * i + 1], value("id", i, 2));
  }
  const std::size_t middle = kSide * kSide / 2;
  EXPECT_NEAR(mask[4 * middle], value("normal", middle, 1), 0.51f / 65535);
  EXPECT_EQ(mask[4 * middle + 2], 1);
}

TEST(ExportMaps, RefusesWhatCannotBePacked) {
  const fs::path out = test::temporary_folder();
  auto maps = some_maps();
  const auto code = [&](const char* path, const char* pack) {
    return test::code_of([&] { test::run_node("Export", maps, {{"path", path}, {"pack", pack}}, out); });
  };
  EXPECT_EQ(code("a.png", "[base_color]"), "bad-value");
  EXPECT_EQ(code("a.png", "[rough]"), "bad-value");
  EXPECT_EQ(code("a.png", "[roughness.a]"), "bad-value");
  EXPECT_EQ(code("a.png", "[height]"), "format-does-not-fit");
  EXPECT_EQ(code("a.jpg", "[roughness]"), "format-does-not-fit");
  EXPECT_EQ(code("a.png", "[black, white]"), "missing-input");
  maps.erase("occlusion");
  EXPECT_EQ(code("a.png", "[occlusion]"), "missing-input");
  maps.erase("roughness");
  maps.emplace("roughness", Value::of(Image(2, 2, 1, 1)));
  EXPECT_EQ(code("a.png", "[roughness]"), "size-mismatch");
  EXPECT_TRUE(fs::is_empty(out));
}

TEST(ExportMaps, RefusesWhatDoesNotFit) {
  const fs::path out = test::temporary_folder();
  const auto maps = some_maps();
  const auto code = [&](const std::multimap<std::string, Value>& inputs, const char* path) {
    return test::code_of([&] { test::run_node("Export", inputs, {{"path", path}}, out); });
  };
  const auto only = [&](const char* name) {
    return std::multimap<std::string, Value>{{name, maps.find(name)->second}};
  };
  EXPECT_EQ(code(only("height"), "height.png"), "format-does-not-fit");
  EXPECT_EQ(code(only("normal"), "normal.jpg"), "format-does-not-fit");
  EXPECT_EQ(code(only("normal"), "m.mtlx"), "missing-input");
  EXPECT_EQ(code(only("normal"), "m.glb"), "missing-input");
  EXPECT_EQ(code(maps, "m.png"), "format-does-not-fit");
  auto small = maps;
  small.erase("normal");
  small.emplace("normal", Value::of(Image(2, 2, 1, 1)));
  EXPECT_EQ(code(small, "m.glb"), "size-mismatch");
  auto broken = only("roughness");
  broken.begin()->second = Value::of(Image(2, 2, 1, 1, Vec3f::Constant(NAN)));
  EXPECT_EQ(code(broken, "r.png"), "bad-pixels");
}

}  // namespace
}  // namespace terrazzo

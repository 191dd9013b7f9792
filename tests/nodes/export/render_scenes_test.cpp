// Scenes for Mitsuba and pbrt, and NanoVDB files. None of these programs is in Debian, so the tests read the
// files by themselves: XML with pugixml, pbrt's tokens here, NanoVDB with its own headers.
#include <gtest/gtest.h>
#include <pugixml.hpp>
#define NANOVDB_USE_ZIP
#include <nanovdb/util/IO.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "nodes/common/geometry/mesh/render_mesh.h"
#include "nodes/common/io/provenance.h"
#include "nodes/export/scene_parts.h"
#include "runtime/random.h"
#include "tests/nodes/export/voxel_files.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace exporting;
namespace fs = std::filesystem;
using test::code_of;

// 200 particles of two shapes, one of them a void, in the box of the volume.
struct Packing {
  Particles particles = test::some_particles(200);
  Shapes shapes = test::two_shapes();
  Volume volume = test::formula_volume();
  Packing() {
    particles.voids.assign(200, 0);
    particles.voids[7] = 1;
    particles.binder_color = {0.2f, 0.4f, 0.6f};
  }
  fs::path write(const std::string& name, bool with_volume,
                 std::map<std::string, std::string> parameters = {}) const {
    std::multimap<std::string, Value> inputs{{"particles", Value::of(particles)},
                                             {"shapes", Value::of(shapes)}};
    if (with_volume) inputs.emplace("volume", Value::of(volume));
    return test::exported(name, inputs, std::move(parameters));
  }
  // Whether a row-major matrix places particle i.
  void expect_matrix(const std::vector<double>& m, std::size_t i) const {
    ASSERT_EQ(m.size(), 16u);
    const Eigen::Matrix3d r = particles.orientation[i].toRotationMatrix() * particles.scale[i];
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(m[4 * row + c], r(int(row), int(c)), 1e-12) << i;
      EXPECT_EQ(m[4 * row + 3], particles.position[i][int(row)]);
      EXPECT_EQ(m[12 + row], 0);
    }
    EXPECT_EQ(m[15], 1);
  }
  // Whether a color is that of a particle, or within one step of the 27 that are left of all.
  void expect_color(const std::vector<double>& c, std::size_t i, double tolerance) const {
    ASSERT_EQ(c.size(), 3u);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(c[std::size_t(k)], particles.color[i][k], tolerance) << i;
  }
};

std::vector<double> numbers(std::string text) {
  for (char& c : text)
    if (c == ',') c = ' ';
  std::istringstream in(text);
  std::vector<double> out;
  for (double v; in >> v;) out.push_back(v);
  return out;
}

void expect_mesh(const fs::path& file, const Shape& shape) {
  const std::string text = test::content_of(file);
  const RenderMesh mesh = render_mesh(shape);
  EXPECT_NE(text.find("element vertex " + std::to_string(mesh.positions.size()) + "\n"), std::string::npos);
  EXPECT_NE(text.find("element face " + std::to_string(mesh.indices.size() / 3) + "\n"), std::string::npos);
  const std::size_t data = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size(), data + 24 * mesh.positions.size() + 13 * (mesh.indices.size() / 3));
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    float v[6];
    std::memcpy(v, text.data() + data + 24 * i, sizeof v);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(v[k], static_cast<float>(mesh.positions[i][k]));
      EXPECT_EQ(v[3 + k], static_cast<float>(mesh.normals[i][k]));
    }
  }
}

TEST(ExportMitsuba, EveryParticleIsAnInstance) {
  const Packing p;
  for (const bool with_volume : {false, true}) {
    const fs::path file = p.write("a b.xml", with_volume, {{"materials", "400"}});
    pugi::xml_document doc;
    ASSERT_TRUE(doc.load_file(file.c_str())) << file;
    const auto scene = doc.child("scene");
    EXPECT_STREQ(scene.attribute("version").value(), "3.0.0");
    std::map<std::string, std::vector<double>> colors;
    for (const auto& b : scene.children("bsdf"))
      colors[b.attribute("id").value()] = numbers(b.child("rgb").attribute("value").value());
    std::map<std::string, std::pair<std::string, std::string>> groups;  // mesh and color
    std::set<std::string> particles, meshes;
    int boxes = 0;
    for (const auto& shape : scene.children("shape")) {
      const std::string type = shape.attribute("type").value(), id = shape.attribute("id").value();
      if (type == "shapegroup") {
        const auto inner = shape.child("shape");
        EXPECT_STREQ(inner.attribute("type").value(), "ply");
        groups[id] = {inner.child("string").attribute("value").value(),
                      inner.child("ref").attribute("id").value()};
        meshes.insert(groups[id].first);
      } else if (type == "instance") {
        EXPECT_TRUE(particles.insert(id).second);
        const auto i = static_cast<std::size_t>(std::stoul(id.substr(9)));
        p.expect_matrix(numbers(shape.child("transform").child("matrix").attribute("value").value()), i);
        const auto group = groups.find(shape.child("ref").attribute("id").value());
        ASSERT_NE(group, groups.end());  // defined before its use
        EXPECT_EQ(group->second.first, "a b_" + std::to_string(p.particles.shape[i]) + ".ply");
        p.expect_color(colors.at(group->second.second), i, 1e-7);  // written as single precision
      } else {
        EXPECT_EQ(type, "cube");
        ++boxes;
      }
    }
    EXPECT_EQ(particles.size(), 199u);
    EXPECT_FALSE(particles.count("particle_7"));
    EXPECT_EQ(meshes.size(), 2u);  // the third shape is not in use
    for (int s = 0; s < 2; ++s)
      expect_mesh(file.parent_path() / ("a b_" + std::to_string(s) + ".ply"),
                  p.shapes.shapes[std::size_t(s)]);
    EXPECT_EQ(boxes, with_volume);
    EXPECT_EQ(test::files_in(file.parent_path()), with_volume ? 4u : 3u);
    EXPECT_TRUE(nlohmann::json::parse(read_provenance(file), nullptr, false).is_object());
    if (!with_volume) continue;
    const auto medium = scene.child("medium");
    EXPECT_EQ(numbers(medium.child("rgb").attribute("value").value()).size(), 3u);
    EXPECT_NEAR(medium.child("float").attribute("value").as_double(), 20 / 1.5, 1e-12);
    const auto volume = medium.child("volume");
    EXPECT_STREQ(volume.child("string").attribute("value").value(), "a b_binder.vol");
    EXPECT_EQ(numbers(volume.child("transform").child("scale").attribute("value").value()),
              (std::vector<double>{1.5, 1.25, 1}));
    const std::string vol = test::content_of(file.parent_path() / "a b_binder.vol");
    ASSERT_EQ(vol.size(), 4u + 5 * 4 + 6 * 4 + 120 * 4);
    EXPECT_EQ(vol.substr(0, 4), "VOL\x03");
    std::int32_t head[5];
    std::memcpy(head, vol.data() + 4, sizeof head);
    EXPECT_EQ(std::vector<std::int32_t>(head, head + 5), (std::vector<std::int32_t>{1, 6, 5, 4, 1}));
    for (int z = 0; z < 4; ++z)
      for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 6; ++x) {
          float v;
          std::memcpy(&v, vol.data() + 48 + 4 * (x + 6 * (y + 5 * z)), 4);
          EXPECT_EQ(v, 1 - std::clamp(test::formula_density(x, y, z), 0.0f, 1.0f));
        }
  }
}

// The tokens of a pbrt file: words, numbers, texts in quotes (with them), brackets.
std::vector<std::string> pbrt_tokens(const std::string& text) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    std::size_t end = at + 1;
    if (c == '#') {
      end = text.find('\n', at);
    } else if (c == '"') {
      end = text.find('"', at + 1) + 1;
      out.push_back(text.substr(at, end - at));
    } else if (c == '[' || c == ']') {
      out.push_back(text.substr(at, 1));
    } else if (!std::isspace(static_cast<unsigned char>(c))) {
      end = text.find_first_of(" \n[]\"", at);
      out.push_back(text.substr(at, end - at));
    }
    at = end;
  }
  return out;
}

TEST(ExportPbrt, EveryParticleIsAnInstance) {
  const Packing p;
  for (const bool with_volume : {false, true}) {
    const fs::path file = p.write("a.pbrt", with_volume, {{"materials", "27"}});
    const auto tokens = pbrt_tokens(test::content_of(file));
    const auto numbers_at = [&](std::size_t& at) {
      std::vector<double> out;
      EXPECT_EQ(tokens[at], "[");
      for (++at; tokens[at] != "]"; ++at) out.push_back(std::stod(tokens[at]));
      return out;
    };
    std::map<std::string, std::vector<double>> colors;
    std::map<std::string, std::pair<std::string, std::string>> groups;
    std::vector<double> matrix;
    std::string open;
    std::size_t next = 0, worlds = 0, depth = 0, media = 0;
    for (std::size_t at = 0; at < tokens.size(); ++at) {
      const std::string& word = tokens[at];
      worlds += word == "WorldBegin";
      media += word == "MakeNamedMedium";
      if (word == "AttributeBegin") ++depth;
      if (word == "AttributeEnd") {
        ASSERT_GT(depth, 0u);
        --depth;
      }
      if (word == "MakeNamedMaterial") {
        const std::string name = tokens[at + 1];
        EXPECT_EQ(tokens[at + 3], "\"diffuse\"");
        EXPECT_EQ(tokens[at + 4], "\"rgb reflectance\"");
        at += 5;
        colors[name] = numbers_at(at);
      } else if (word == "ObjectBegin") {
        open = tokens[++at];
      } else if (word == "NamedMaterial") {
        groups[open].second = tokens[++at];
      } else if (word == "Shape" && !open.empty()) {
        EXPECT_EQ(tokens[at + 1], "\"plymesh\"");
        groups[open].first = tokens[at + 3];
        at += 3;
      } else if (word == "ObjectEnd") {
        open.clear();
      } else if (word == "Transform") {
        EXPECT_EQ(depth, 1u);
        const auto m = numbers_at(++at);
        ASSERT_EQ(m.size(), 16u);
        matrix.assign(16, 0);
        for (std::size_t k = 0; k < 16; ++k) matrix[4 * (k % 4) + k / 4] = m[k];  // the file has columns
      } else if (word == "ObjectInstance") {
        next += next == 7;  // the void
        const auto group = groups.find(tokens[at + 1]);
        ASSERT_NE(group, groups.end());
        p.expect_matrix(matrix, next);
        EXPECT_EQ(group->second.first, "\"a_" + std::to_string(p.particles.shape[next]) + ".ply\"");
        p.expect_color(colors.at(group->second.second), next, 0.75);
        ++next;
      }
    }
    EXPECT_EQ(next, 200u);
    EXPECT_EQ(depth, 0u);
    EXPECT_EQ(worlds, 1u);
    EXPECT_EQ(media, std::size_t(with_volume));
    EXPECT_LE(colors.size(), 27u);
    EXPECT_GT(colors.size(), 8u);
    EXPECT_TRUE(nlohmann::json::parse(read_provenance(file), nullptr, false).is_object());
    if (!with_volume) continue;
    const auto grid = nanovdb::io::readGrid((file.parent_path() / "a_binder.nvdb").string());
    ASSERT_TRUE(grid.grid<float>());
    EXPECT_STREQ(grid.grid<float>()->gridName(), "density");
    const auto box = grid.grid<float>()->worldBBox();
    EXPECT_NEAR(box.dim()[0], 1.5, 1e-6);
    const auto& tree = grid.grid<float>()->tree();
    for (int z = 0; z < 4; ++z)
      EXPECT_EQ(tree.getValue(nanovdb::Coord(5, 4, z)),
                1 - std::clamp(test::formula_density(5, 4, z), 0.0f, 1.0f));
  }
}

// The triangles of the box of the medium face outward.
TEST(ExportPbrt, TheBoxOfTheBinderFacesOutward) {
  const Packing p;
  const auto tokens = pbrt_tokens(test::content_of(p.write("a.pbrt", true)));
  const auto list = [&](const std::string& name) {
    std::vector<double> out;
    auto it = std::find(tokens.begin(), tokens.end(), name) + 2;
    for (; *it != "]"; ++it) out.push_back(std::stod(*it));
    return out;
  };
  const auto indices = list("\"integer indices\""), points = list("\"point3 P\"");
  ASSERT_EQ(indices.size(), 36u);
  ASSERT_EQ(points.size(), 24u);
  const Vec3 center(0.75, 0.625, 0.5);
  double area = 0;
  for (std::size_t t = 0; t < 36; t += 3) {
    Vec3 v[3];
    for (std::size_t k = 0; k < 3; ++k)
      for (int a = 0; a < 3; ++a) v[k][a] = points[3 * std::size_t(indices[t + k]) + std::size_t(a)];
    const Vec3 n = (v[1] - v[0]).cross(v[2] - v[0]);
    EXPECT_GT(n.dot(v[0] - center), 0) << t / 3;
    area += n.norm() / 2;
  }
  EXPECT_NEAR(area, 2 * (1.5 * 1.25 + 1.5 + 1.25), 1e-9);
}

TEST(ExportNvdb, HoldsTheSameValues) {
  const Volume v = test::formula_volume();
  const fs::path out = test::temporary_folder();
  const auto run = test::run_node("Export", {{"volume", Value::of(v)}}, {{"path", "a.nvdb"}}, out);
  ASSERT_EQ(run.warnings.size(), 1u);
  EXPECT_NE(run.warnings[0].find("'source' is left out"), std::string::npos);
  const auto grids = nanovdb::io::readGrids((out / "a.nvdb").string());
  ASSERT_EQ(grids.size(), 3u);
  std::set<std::string> names;
  for (const auto& handle : grids) {
    const std::string name = handle.gridMetaData()->shortGridName();
    names.insert(name);
    EXPECT_NEAR(handle.gridMetaData()->voxelSize()[0], 0.25, 1e-12);
    const auto check = [&](const auto* grid, const auto& same) {
      ASSERT_TRUE(grid) << name;
      const nanovdb::Vec3d center = grid->indexToWorld(nanovdb::Vec3d(1, 0, 0));
      EXPECT_NEAR(center[0], 0.375, 1e-12);
      for (int z = 0; z < 4; ++z)
        for (int y = 0; y < 5; ++y)
          for (int x = 0; x < 6; ++x) same(grid->tree().getValue(nanovdb::Coord(x, y, z)), x, y, z);
    };
    if (name == "id")
      check(handle.grid<std::int32_t>(),
            [](std::int32_t value, int x, int y, int z) { EXPECT_EQ(value, test::formula_id(x, y, z)); });
    else if (name == "density")
      check(handle.grid<float>(),
            [](float value, int x, int y, int z) { EXPECT_EQ(value, test::formula_density(x, y, z)); });
    else
      check(handle.grid<nanovdb::Vec3f>(), [](const nanovdb::Vec3f& value, int x, int, int z) {
        EXPECT_EQ(value[1], 0.25f * float(x));
        EXPECT_EQ(value[2], float(z));
      });
  }
  EXPECT_EQ(names, (std::set<std::string>{"id", "density", "Cd"}));
}

TEST(RenderScenes, SayWhatTheyCannotHold) {
  const Packing p;
  const auto code = [&](const std::string& path, std::multimap<std::string, Value> inputs,
                        std::map<std::string, std::string> parameters = {}) {
    const fs::path out = test::temporary_folder();
    parameters["path"] = path;
    const std::string found = code_of([&] { test::run_node("Export", inputs, parameters, out); });
    EXPECT_EQ(test::files_in(out), 0u) << path;
    return found;
  };
  const Value particles = Value::of(p.particles), shapes = Value::of(p.shapes), volume = Value::of(p.volume);
  EXPECT_EQ(code("a.nvdb", {{"volume", Value::of(Volume())}}), "no-grids");
  EXPECT_EQ(code("a.nvdb", {{"volume", volume}}, {{"grids", "[source]"}}), "unsupported-grid");
  Volume only_ids = p.volume;
  only_ids.grids.resize(1);
  for (const std::string end : {".xml", ".pbrt"}) {
    EXPECT_EQ(code("a" + end, {{"particles", particles}}), "no-shapes");
    EXPECT_EQ(code("a" + end, {{"shapes", shapes}}), "missing-input");
    EXPECT_EQ(code("a\"b" + end, {{"particles", particles}, {"shapes", shapes}}), "bad-names");
    EXPECT_EQ(
        code("a" + end, {{"particles", particles}, {"shapes", shapes}, {"volume", Value::of(only_ids)}}),
        "no-such-grid");
    Shapes broken = p.shapes;
    broken.shapes[1].mesh.vertices[0].x() = std::nan("");
    EXPECT_EQ(code("a" + end, {{"particles", particles}, {"shapes", Value::of(broken)}}), "bad-number");
    Particles none = p.particles;
    none.voids.assign(200, 1);
    EXPECT_EQ(code("a" + end, {{"particles", Value::of(none)}, {"shapes", shapes}}), "no-particles");
  }
}

}  // namespace
}  // namespace terrazzo

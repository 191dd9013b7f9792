#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/geometry/grid/spaced_transform.h"
#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "nodes/data/volume.h"
#include "nodes/volumes/render_volume/tissue.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace render_volume;
using render_volume::parse_tissues;
using test::code_of;
using test::run_node;
using Inputs = std::multimap<std::string, Value>;
using Parameters = std::map<std::string, std::string>;

Volume scan(const Vec3i& n, float inside = 50, float outside = -1000) {
  initialize_openvdb();
  Volume v;
  auto grid = dense_grid<openvdb::FloatGrid>("density", n, 1, {}, [&](std::size_t i) {
    const Vec3i p(static_cast<int>(i) % n.x(), static_cast<int>(i) / n.x() % n.y(),
                  static_cast<int>(i) / n.x() / n.y());
    const bool in = (p.cast<double>() - 0.5 * (n.cast<double>() - Vec3::Ones())).norm() < 0.4 * n.maxCoeff();
    return in ? inside : outside;
  });
  grid->setTransform(voxel_transform(Vec3(1, 1, 2)));
  v.grids.push_back(grid);
  return v;
}

Volume texture(const Vec3f& color) {
  Volume v;
  v.resolution = Vec3i(4, 4, 4);
  v.grids.push_back(dense_grid<openvdb::Vec3SGrid>("Cd", v.resolution, 0.5, {}, [&](std::size_t) {
    return openvdb::Vec3s(color.x(), color.y(), color.z());
  }));
  return v;
}

test::NodeRun run(const Inputs& inputs, Parameters more = {}, int threads = 0) {
  more.insert({{"width", "40"}, {"height", "32"}});
  return run_node("RenderVolume", inputs, more, {}, threads);
}
std::string failure(const Inputs& inputs, const Parameters& more = {}) {
  return code_of([&] { run(inputs, more); });
}

TEST(RenderVolume, TexturesGoToTheClassesThatAskForOne) {
  const Value volume = Value::of(scan(Vec3i(16, 16, 16), 50, -100));  // a ball of muscle in fat
  const Value red = Value::of(texture(Vec3f(0.8f, 0.1f, 0.1f))),
              blue = Value::of(texture(Vec3f(0.1f, 0.1f, 0.8f)));
  const Parameters cut = {{"classes", "[muscle -30 150 texture, fat -190 -30 texture, skin -600 -190 noise]"},
                          {"clip", "[0, 1, 0, 1, 0, 0.5]"},
                          {"elevation", "80"}};
  const auto image =
      run({{"volume", volume}, {"textures", red}, {"textures", blue}}, cut).output<Image>("image");
  EXPECT_GT(image.at(20, 16).z(), 2 * image.at(20, 16).x()) << "muscle, whose range comes second, is blue";
  EXPECT_EQ(failure({{"volume", volume}, {"textures", red}}, cut), "missing-texture");
  EXPECT_EQ(failure({{"volume", volume}, {"textures", red}, {"textures", red}, {"textures", red}}, cut),
            "spare-texture");
  EXPECT_EQ(failure({{"volume", volume}}, cut), "");
}

TEST(RenderVolume, FramesMakeAFullTurn) {
  const Value volume = Value::of(scan(Vec3i(16, 12, 8)));
  const auto turn = run({{"volume", volume}}, {{"frames", "4"}, {"azimuth", "10"}});
  const auto& image = turn.output<Image>("image");
  ASSERT_EQ(image.sections, 4);
  const auto one = run({{"volume", volume}}, {{"azimuth", "100"}}).output<Image>("image");
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) ASSERT_EQ(image.at(x, y, 1), one.at(x, y));
  const auto& table = turn.output<Table>("table");
  ASSERT_EQ(table.rows.size(), 4u);
  EXPECT_EQ(table.number(1, "azimuth degrees"), 100);
  EXPECT_GT(table.number(1, "samples"), table.number(1, "rays"));
  EXPECT_EQ(table.number(1, "texture lookups"), 0);
}

TEST(RenderVolume, ClipShowsTheInside) {
  Volume v = scan(Vec3i(20, 20, 20), 50, -100);  // muscle in fat
  const Parameters plain = {{"elevation", "70"}, {"modulation", "0"}};
  const auto whole = run({{"volume", Value::of(v)}}, plain).output<Image>("image").at(20, 16);
  Parameters cut = plain;
  cut["clip"] = "[0, 1, 0, 1, 0, 0.5]";
  const auto inside = run({{"volume", Value::of(v)}}, cut).output<Image>("image").at(20, 16);
  EXPECT_GT(inside.x() / inside.y(), 1.5f * whole.x() / whole.y()) << "muscle is redder than fat";
}

TEST(RenderVolume, TranslucencyNeedsTheProcessor) {
  const Inputs in = {{"volume", Value::of(scan(Vec3i(16, 12, 8)))}};
  EXPECT_EQ(failure(in, {{"translucency", "0.5"}, {"device", "gl"}}), "bad-value");
  EXPECT_EQ(failure(in, {{"translucency", "0.5"}, {"device", "auto"}}), "bad-value");
  EXPECT_EQ(failure(in, {{"lamp", "[0, 0, 0]"}}), "bad-lamp");
  EXPECT_EQ(failure(in, {{"classes", "[muscle -30 150 penetration=0]"}}), "bad-class");
  const Parameters muscle = {{"translucency", "1"}, {"classes", "[muscle -30 150 penetration=1]"}};
  Parameters deeper = muscle;
  deeper["classes"] = "[muscle -30 150 penetration=50]";
  const auto light = [&](const Parameters& p) {
    const test::NodeRun rendered = run(in, p);  // holds the picture
    Vec3f sum = Vec3f::Zero();
    for (const Vec3f& v : rendered.output<Image>("image").pixels) sum += v;
    return sum.sum();
  };
  EXPECT_GT(light(deeper), light(muscle) + 5);
}

TEST(RenderVolume, UpTurnsThePicture) {
  // A stick along x is upright when x points up.
  initialize_openvdb();
  Volume v;
  const Vec3i n(30, 30, 30);
  v.grids.push_back(dense_grid<openvdb::FloatGrid>("density", n, 1, {}, [&](std::size_t i) {
    const int y = static_cast<int>(i) / 30 % 30, z = static_cast<int>(i) / 900;
    return std::abs(y - 15) < 4 && std::abs(z - 15) < 4 ? 50.0f : -1000.0f;
  }));
  const auto extent = [&](const char* up) {
    const auto image =
        run({{"volume", Value::of(v)}},
            {{"up", up}, {"elevation", "0"}, {"azimuth", "0"}, {"width", "40"}, {"height", "40"}})
            .output<Image>("image");
    int rows = 0;
    for (int y = 0; y < 40; ++y) rows += image.at(20, y).z() < 0.5f;
    return rows;
  };
  EXPECT_GT(extent("x"), 2 * extent("z"));
}

TEST(RenderVolume, OnePictureForAnyNumberOfThreads) {
  const Inputs in = {{"volume", Value::of(scan(Vec3i(20, 18, 9)))}};
  EXPECT_EQ(run(in, {}, 1).output<Image>("image").pixels, run(in, {}, 3).output<Image>("image").pixels);
}

TEST(RenderVolume, SaysWhichDeviceDrew) {
  const Inputs in = {{"volume", Value::of(scan(Vec3i(16, 12, 8)))}};
  const auto cpu = run(in);
  EXPECT_TRUE(cpu.warnings.empty());
  const auto any = run(in, {{"device", "auto"}});  // a warning names the device
  ASSERT_EQ(any.warnings.size(), 1u);
  EXPECT_TRUE(any.warnings[0].starts_with("rendered ")) << any.warnings[0];
  const auto &a = cpu.output<Image>("image"), &b = any.output<Image>("image");
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += (a.pixels[i] - b.pixels[i]).cwiseAbs().sum() / 3;
  EXPECT_LT(sum / double(a.pixels.size()), 1.0 / 255);
  try {
    const auto gl = run(in, {{"device", "gl"}});
    ASSERT_EQ(gl.warnings.size(), 1u);
    EXPECT_TRUE(gl.warnings[0].starts_with("rendered by OpenGL on ")) << gl.warnings[0];
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "no-gl");
  }
}

TEST(RenderVolume, ClassesAreReadAndSorted) {
  const auto t = parse_tissues({"bone 150 4000 #ffffff texture", "skin -600 -190.5 noise opacity=0.25"});
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].name, "skin");
  EXPECT_EQ(t[0].high, -190.5);
  EXPECT_EQ(t[0].opacity, 0.25);
  EXPECT_LT(t[1].opacity, 0);
  EXPECT_EQ(t[1].color, Vec3f(Vec3f::Ones()));
  const auto i = render_volume::intervals_of(parse_tissues({"b 5 9", "a 1 5", "c 20 30"}));
  EXPECT_EQ(i.edges, (std::vector<float>{1, 5, 9, 20, 30}));
  EXPECT_EQ(i.tissue, (std::vector<int>{-1, 0, 1, -1, 2, -1}));
}

TEST(RenderVolume, BadClasses) {
  const auto code = [](const std::vector<std::string>& c) { return code_of([&] { parse_tissues(c); }); };
  EXPECT_EQ(code({"fat -190 -30", "muscle -40 150"}), "overlapping-classes");
  for (const char* c : {"fat", "fat -190", "fat x 3", "fat 3 3", "fat 5 1", "fat 1 nan", "fat 1 2 #12345",
                        "fat 1 2 #12345x", "fat 1 2 velvet", "fat 1 2 opacity=2", "fat 1 2 opacity="})
    EXPECT_EQ(code({c}), "bad-class") << c;
  EXPECT_EQ(code({"a 1 2", "a 3 4"}), "bad-class");
}

TEST(RenderVolume, BadInput) {
  const Value good = Value::of(scan(Vec3i(8, 8, 8)));
  EXPECT_EQ(failure({{"volume", Value::of(Volume())}}), "no-grid");
  EXPECT_EQ(failure({{"volume", good}}, {{"grid", "Cd"}}), "no-grid");
  EXPECT_EQ(failure({{"volume", Value::of(scan(Vec3i(1, 1, 1)))}}), "too-small");
  EXPECT_EQ(failure({{"volume", Value::of(scan(Vec3i(8, 8, 1)))}}), "too-small");
  EXPECT_EQ(failure({{"volume", Value::of(scan(Vec3i(8, 8, 8), 3, 3))}}), "no-contrast");
  EXPECT_EQ(failure({{"volume", Value::of(scan(Vec3i(8, 8, 8), NAN))}}), "bad-values");
  EXPECT_EQ(failure({{"volume", Value::of(scan(Vec3i(8, 8, 8), INFINITY))}}), "bad-values");
  EXPECT_EQ(failure({{"volume", good}}, {{"clip", "[0, 1, 0.5, 0.5, 0, 1]"}}), "bad-clip");
  EXPECT_EQ(failure({{"volume", good}}, {{"window", "[5, 5]"}}), "bad-window");
  EXPECT_EQ(failure({{"volume", good}}, {{"weights", "[0, 0, 0]"}}), "bad-weights");
  EXPECT_EQ(failure({{"volume", good}}, {{"classes", "[a 0 10, b 5 20]"}}), "overlapping-classes");
  Volume empty;
  empty.grids.push_back(openvdb::FloatGrid::create(0));
  EXPECT_EQ(failure({{"volume", Value::of(empty)}}), "empty-volume");
  Volume colorless = scan(Vec3i(4, 4, 4));
  EXPECT_EQ(failure({{"volume", good}, {"textures", Value::of(colorless)}}), "no-color");
  EXPECT_EQ(failure({{"volume", good}, {"textures", Value::of(texture(Vec3f(NAN, 0, 0)))}}), "bad-colors");
  const auto nothing = run({{"volume", good}}, {{"classes", "[metal 5000 6000]"}});
  EXPECT_EQ(nothing.warnings.size(), 1u);
}

}  // namespace
}  // namespace terrazzo

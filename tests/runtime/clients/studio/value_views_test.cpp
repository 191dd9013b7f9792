// Values in the forms that the page draws.
#include "runtime/clients/studio/views/value_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "nodes/common/geometry/grid/dense_grid.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/volume.h"
#include "tests/nodes/bodies/section/packing.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using nlohmann::json;
using studio::view_of;

template <class T>
T at(const std::string& bytes, std::size_t word) {
  T out;
  EXPECT_LE(4 * word + 4, bytes.size());
  std::memcpy(&out, bytes.data() + 4 * word, 4);
  return out;
}

TEST(StudioViews, PicturesAreReducedByAWholeFactor) {
  Image image(100, 50, 2, 1, Vec3f(1, 0, 0));
  image.at(3, 0, 1) = Vec3f(0, 1, 0);
  const auto view = studio::view_of(Value::of(image), "pixels", {.most = 40, .slice = {.index = 1}});
  std::uint32_t head[5];
  std::memcpy(head, view.body.data(), sizeof head);
  EXPECT_EQ(head[0], 34u);
  EXPECT_EQ(head[1], 17u);
  EXPECT_EQ(head[2], 2u);
  EXPECT_EQ(head[3], 100u);
  EXPECT_EQ(view.body.size(), 20u + 34 * 17 * 4);
  EXPECT_EQ(view.body.substr(20, 8), std::string("\xff\x00\x00\xff\x00\xff\x00\xff", 8));
  EXPECT_EQ(test::code_of([] { studio::view_of(Value::of(Image{}), "pixels"); }), "empty-image");
  EXPECT_EQ(test::code_of([&] { studio::view_of(Value::of(image), "ids"); }), "bad-request");
}

// The bytes come from a table.
TEST(StudioViews, PixelsAreThoseOfTheEncoding) {
  Image image(1000, 300, 1, 1);
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k < image.pixels.size(); ++k)
    for (int c = 0; c < 3; ++c, bits += 1187)  // from 0 to 1.1, dense near 0
      image.pixels[k][c] = std::bit_cast<float>(bits);
  image.pixels[0] = Vec3f(-1, std::nanf(""), 1e30f);
  image.pixels[1] = Vec3f(1, 0.5f, INFINITY);
  const std::string bytes = view_of(Value::of(image), "pixels").body.substr(20);
  for (std::size_t k = 0; k < image.pixels.size(); ++k)
    for (int c = 0; c < 3; ++c) {
      const float v = linear_to_srgb(image.pixels[k])[c];
      const long expected = std::isfinite(v) ? std::lround(255 * std::clamp(v, 0.0f, 1.0f)) : 0;
      ASSERT_EQ(static_cast<unsigned char>(bytes[4 * k + c]), expected) << image.pixels[k][c];
    }
}

// When one profile is split, the others keep their colors, though they get other numbers.
TEST(StudioViews, ProfilesKeepTheirColors) {
  const auto pixels = [](std::vector<std::int32_t> ids, int count) {
    Labels l;
    l.width = 4;
    l.height = 2;
    l.ids = std::move(ids);
    l.classes.assign(count, 0);
    const std::string body = studio::view_of(Value::of(std::move(l)), "pixels", {}).body;
    std::vector<std::uint32_t> out((body.size() - 20) / 4);
    std::memcpy(out.data(), body.data() + 20, 4 * out.size());
    return out;
  };
  const auto before = pixels({1, 1, 0, 2, 1, 1, 0, 2}, 2), after = pixels({1, 2, 0, 3, 1, 2, 0, 3}, 3);
  EXPECT_EQ(after[0], before[0]);
  EXPECT_EQ(after[2], before[2]);
  EXPECT_EQ(after[7], before[7]);
  EXPECT_NE(after[1], before[1]);
}

TEST(StudioViews, ParticlesAreRowsOfNumbers) {
  Particles p;
  p.box = Vec3(4, 5, 6);
  p.resize(2);
  p.position[1] = Vec3(1, 2, 3), p.scale[1] = 0.5, p.size[1] = 0.25, p.shape[1] = 7,
  p.color[1] = Vec3f(1, 0, 0);
  p.voids = {1, 0};
  const std::string v = view_of(Value::of(p), "particles").body;
  ASSERT_EQ(v.size(), 20u + 2 * 44);
  EXPECT_EQ(at<std::uint32_t>(v, 0), 2u);
  EXPECT_EQ(at<std::uint32_t>(v, 1), 44u);
  EXPECT_EQ(at<float>(v, 3), 5);
  const std::size_t second = 5 + 11;
  EXPECT_EQ(at<float>(v, second + 2), 3);
  EXPECT_EQ(at<float>(v, second + 6), 1);  // w of no rotation
  EXPECT_EQ(at<float>(v, second + 7), 0.5f);
  EXPECT_EQ(at<std::uint32_t>(v, second + 9), 7u);
  EXPECT_EQ(at<std::uint32_t>(v, second + 10), 0xff0000ffu);
  EXPECT_EQ(at<std::uint32_t>(v, 5 + 10) >> 24, 0u);  // a void
  Particles many;
  many.resize(400'001);
  EXPECT_EQ(test::code_of([&] { view_of(Value::of(many), "particles"); }), "too-large");
}

TEST(StudioViews, ShapesAreReducedToAboutTheirTriangles) {
  const Value sphere =
      test::run_node("Shape", {}, {{"kind", "sphere"}, {"detail", "4"}}).outputs.begin()->second;
  const std::size_t full = sphere.as<Shapes>().shapes.at(0).mesh.triangles.size();
  const std::string v = view_of(sphere, "meshes", {.most = 60}).body;
  EXPECT_EQ(at<std::uint32_t>(v, 0), 1u);
  const auto vertices = at<std::uint32_t>(v, 1), indices = at<std::uint32_t>(v, 2);
  EXPECT_LE(indices, 3 * 66u);
  EXPECT_GE(indices, 3 * 20u);
  EXPECT_EQ(at<std::uint32_t>(v, 3), full);
  ASSERT_EQ(v.size(), 4u * (5 + 6 * vertices + indices));
  for (std::uint32_t k = 0; k < indices; ++k) EXPECT_LT(at<std::uint32_t>(v, 5 + 6 * vertices + k), vertices);
  EXPECT_EQ(test::code_of([&] { view_of(sphere, "particles"); }), "bad-request");
}

// Cd is red where x is 0 and green elsewhere; density is 1 where z is 0.
Volume block() {
  initialize_openvdb();
  Volume out;
  const Vec3i size(3, 4, 5);
  out.grids.push_back(dense_grid<openvdb::Vec3SGrid>("Cd", size, 0.5, {}, [](std::size_t i) {
    return i % 3 == 0 ? openvdb::Vec3s(1, 0, 0) : openvdb::Vec3s(0, 1, 0);
  }));
  out.grids.push_back(dense_grid<openvdb::FloatGrid>("density", size, 0.5, {},
                                                     [](std::size_t i) { return i < 12 ? 1.0f : 0.0f; }));
  return out;
}

TEST(StudioViews, RangesOfQuantitiesAreWithoutOutliers) {
  initialize_openvdb();
  Volume volume;
  volume.grids.push_back(dense_grid<openvdb::FloatGrid>("flow", Vec3i(10, 10, 10), 1, {}, [](std::size_t i) {
    return i == 500 ? 1e6f : static_cast<float>(i);
  }));
  volume.grids.push_back(
      dense_grid<openvdb::FloatGrid>("even", Vec3i(4, 4, 4), 1, {}, [](std::size_t) { return 3.0f; }));
  const json grids = json::parse(view_of(Value::of(volume), "head").body)["grids"];
  const double bin = 1e6 / 4096;
  EXPECT_EQ(grids[0]["range"], json({0.0, 1e6}));
  EXPECT_NEAR(grids[0]["shown"][0].get<double>(), 5, bin);
  EXPECT_NEAR(grids[0]["shown"][1].get<double>(), 995, bin);
  EXPECT_NEAR(grids[0]["most"].get<double>(), 800, bin);
  EXPECT_EQ(grids[1]["shown"][1], 3.0);
}

TEST(StudioViews, SlicesAreTheWayUpThatSectionsAre) {
  const Value v = Value::of(block());
  const json head = json::parse(view_of(v, "head").body);
  EXPECT_EQ(head["size"], json({3, 4, 5}));
  EXPECT_EQ(head["spacing"][0], 0.5);
  EXPECT_EQ(head["grids"][1]["range"], json({0.0, 1.0}));
  EXPECT_FALSE(head["grids"][0].contains("shown"));
  const auto slice = [&](int axis, int index, const char* grid) {
    return view_of(v, "slice", {.slice = {.grid = grid, .axis = axis, .index = index}}).body;
  };
  // Across y: x to the right, z up; so the last row has z = 0.
  const std::string y = slice(1, 2, "density");
  EXPECT_EQ(at<std::uint32_t>(y, 0), 3u);
  EXPECT_EQ(at<std::uint32_t>(y, 1), 5u);
  EXPECT_EQ(at<std::uint32_t>(y, 2), 4u);
  EXPECT_EQ(at<std::uint32_t>(y, 5), 0xff000000u);
  EXPECT_EQ(at<std::uint32_t>(y, 5 + 3 * 4), 0xffffffffu);
  // Across x, everything is red at 0, and an index beyond the end is the last plane.
  EXPECT_EQ(at<std::uint32_t>(slice(0, 0, "Cd"), 5 + 7), 0xff0000ffu);
  EXPECT_EQ(at<std::uint32_t>(slice(0, 99, "Cd"), 5 + 7), 0xff00ff00u);
  EXPECT_EQ(test::code_of([&] { slice(0, 0, "nothing"); }), "no-such-grid");
  EXPECT_EQ(test::code_of([] { view_of(Value::of(Volume{}), "slice"); }), "no-grids");
}

TEST(StudioViews, VoxelsAreReducedByAWholeFactorWithCoverageAsAlpha) {
  const Value v = Value::of(block());
  const std::string all = view_of(v, "voxels", {.slice = {.grid = "Cd"}}).body;
  ASSERT_EQ(all.size(), 4u * (4 + 60));
  EXPECT_EQ(at<std::uint32_t>(all, 4), 0xff0000ffu);       // z = 0: covered
  EXPECT_EQ(at<std::uint32_t>(all, 4 + 59), 0x0000ff00u);  // z = 4: binder
  const std::string less = view_of(v, "voxels", {.most = 3, .slice = {.grid = "Cd"}}).body;
  EXPECT_EQ(at<std::uint32_t>(less, 0), 2u);
  EXPECT_EQ(at<std::uint32_t>(less, 2), 3u);
  EXPECT_EQ(at<std::uint32_t>(less, 3), 2u);
}

}  // namespace
}  // namespace terrazzo

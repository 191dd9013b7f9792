#include "nodes/detail/detail_solid/lines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "nodes/data/indices.h"
#include "nodes/data/particles.h"
#include "nodes/detail/residual/camera_noise.h"
#include "nodes/detail/residual/residual_field.h"
#include "nodes/detail/residual/scratches.h"
#include "nodes/detail/residual/sheet_field.h"
#include "nodes/detail/residual/wave_field.h"
#include "runtime/codec.h"
#include "runtime/random.h"
#include "tests/nodes/detail/detail_solid/drawn_picture.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

constexpr int kLinesEdge = 384;

struct Stroke {
  double x, y, angle, length;  // the middle, pixels; from the right downwards
};

// How much a line of Gaussian profile covers a pixel.
double share_of(const Stroke& s, double x, double y, double width) {
  const double c = std::cos(s.angle), d = std::sin(s.angle), u = (x - s.x) * c + (y - s.y) * d,
               v = (y - s.y) * c - (x - s.x) * d;
  return std::abs(u) < s.length / 2 ? std::exp(-v * v / (2 * width * width)) : 0;
}

// Disks with grain, and dark lines of deviation `width` where `shown`.
template <class Shown>
test::DrawnPicture drawn_lines(const std::vector<Stroke>& strokes, double width, double radius,
                               Shown&& shown) {
  return test::draw_disks(kLinesEdge, 96, radius, [&](int x, int y, int id) {
    Random random(3, static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y));
    double value = (id == 0 ? 0.7 : 0.4) + 0.01 * random.normal();
    if (shown(id))
      for (const Stroke& s : strokes) value -= (id == 0 ? 0.03 : 0.1) * share_of(s, x, y, width);
    return Vec3f(Vec3f::Constant(static_cast<float>(value)));
  });
}

// Lines of 30 pixels in the disks, in many directions.
std::vector<Stroke> crack_strokes() {
  std::vector<Stroke> out;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      for (const double side : {-12.0, 12.0}) {
        const double angle = 0.9 * (i + 4 * j), x = 96 * i + 48, y = 96 * j + 48;
        out.push_back({x - side * std::sin(angle), y + side * std::cos(angle), angle, 30});
      }
  return out;
}

// Lines of 120 pixels in three directions.
std::vector<Stroke> scratch_strokes() {
  std::vector<Stroke> out;
  for (int k = 0; k < 6; ++k) out.push_back({52.0 + 56 * k, 40.0 + 97 * (k % 4), 0.3 + k % 3 * 0.9, 120});
  return out;
}

Detail lines_detail_of(const test::DrawnPicture& drawn, int threads = 1) {
  const auto run =
      test::run_node("DetailSolid", {{"image", Value::of(drawn.image)}, {"labels", Value::of(drawn.labels)}},
                     {{"size", "16"}, {"groups", "1"}, {"lines", "true"}}, {}, threads);
  return run.outputs.at("detail").as<Detail>();
}

std::vector<char> bytes_of_lines(const Detail& detail) {
  BufferWriter writer;
  value_type<Detail>().encode(&detail, writer);
  return {writer.buffer.begin(), writer.buffer.end()};
}

TEST(DetailLines, CracksAreMeasured) {
  const auto drawn = drawn_lines(crack_strokes(), 0.9, 44, [](int id) { return id > 0; });
  const Detail detail = lines_detail_of(drawn);
  const Detail::Sheets& sheets = detail.phases[1].sheets;
  double area = 0;
  for (const std::int32_t id : drawn.labels.ids) area += id > 0;
  EXPECT_NEAR(sheets.density, 32 * 30 / area, 0.25 * 32 * 30 / area);
  EXPECT_NEAR(sheets.length, 30, 6);
  EXPECT_NEAR(sheets.width, 0.9, 0.25);
  EXPECT_LT(sheets.bend, 1);
  EXPECT_NEAR(sheets.offset.mean(), -0.1f / Detail::particle_scale(Vec3f::Constant(0.4f)), 0.04f);
  EXPECT_EQ(detail.phases[0].sheets.density, 0);
  EXPECT_TRUE(detail.scratches.empty());
}

TEST(DetailLines, ScratchesAreMeasuredAndDrawn) {
  const auto drawn = drawn_lines(scratch_strokes(), 1, 16, [](int id) { return id == 0; });
  const Detail detail = lines_detail_of(drawn);
  ASSERT_GE(detail.scratches.size(), 4U);
  constexpr int kMiddle = Detail::Scratch::kReach;
  const Detail::Scratch& clearest =
      *std::min_element(detail.scratches.begin(), detail.scratches.end(),
                        [](const auto& a, const auto& b) { return a.profile[kMiddle] < b.profile[kMiddle]; });
  double nearest = 1;
  for (const double angle : {0.3, 1.2, 2.1})
    nearest = std::min(nearest,
                       std::abs(std::remainder(std::numbers::pi - angle - clearest.angle, std::numbers::pi)));
  EXPECT_LT(nearest, 0.05);
  EXPECT_NEAR(clearest.profile[kMiddle], -0.03f, 0.015f);
  EXPECT_EQ(detail.phases[0].sheets.density, 0);  // they belong to the picture
  residual::Camera camera = residual::camera_of(detail, 7);
  double dark = 0, pictures = 20;
  for (int picture = 0; picture < pictures; ++picture) {
    Image out(kLinesEdge, kLinesEdge, 1, detail.pixel_size, srgb_to_linear(Vec3f::Constant(0.7f)));
    const std::vector<float> cover(out.pixels.size(), 0.0f);
    residual::add_scratches(out.pixels.data(), cover, kLinesEdge, kLinesEdge, detail.pixel_size, false,
                            camera, static_cast<std::uint64_t>(picture), Work());
    for (const Vec3f& v : out.pixels) dark += 0.7 - linear_to_srgb(v).mean();
  }
  double expected = 0;
  for (const Detail::Scratch& s : detail.scratches)
    for (const float v : s.profile)
      expected -= v * (s.length - 6) * kLinesEdge * kLinesEdge / s.area;  // both ends fade
  EXPECT_NEAR(dark / pictures, expected, 0.2 * expected);
}

TEST(DetailLines, GrainAndBlotchesAreNoLines) {
  const residual::WaveField field(std::array{3.0f}, std::array{1.0f},
                                  Vec3(kLinesEdge, kLinesEdge, kLinesEdge));
  const auto drawn = test::draw_disks(kLinesEdge, 96, 40, [&](int x, int y, int id) {
    Random random(4, static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y));
    const float blotch = field.at({static_cast<float>(x), static_cast<float>(y), 5});
    const bool speck = random.uniform() < 0.01;
    return Vec3f(Vec3f::Constant((id == 0 ? 0.7f : 0.4f) + 0.02f * blotch + (speck ? 0.1f : 0)));
  });
  const Detail detail = lines_detail_of(drawn);
  for (const Detail::Phase& phase : detail.phases) EXPECT_EQ(phase.sheets.density, 0);
  EXPECT_TRUE(detail.scratches.empty());
}

TEST(DetailLines, AreTheSameForAnyNumberOfThreads) {
  const auto drawn = drawn_lines(crack_strokes(), 0.9, 44, [](int id) { return id > 0; });
  const auto one = bytes_of_lines(lines_detail_of(drawn, 1));
  EXPECT_TRUE(bytes_of_lines(lines_detail_of(drawn, 3)) == one);
}

TEST(DetailLines, AreStored) {
  Detail detail = lines_detail_of(drawn_lines(crack_strokes(), 0.9, 44, [](int id) { return id > 0; }));
  ASSERT_GT(detail.phases[1].sheets.density, 0);
  detail.scratches = {{0.5f, 30, 1000, {1, 2, 3}}};
  const std::vector<char> bytes = bytes_of_lines(detail);
  Reader reader(bytes.data(), bytes.size());
  const auto back = std::static_pointer_cast<const Detail>(value_type<Detail>().decode(reader));
  EXPECT_TRUE(bytes_of_lines(*back) == bytes);
  EXPECT_EQ(back->phases[1].sheets.density, detail.phases[1].sheets.density);
  EXPECT_EQ(back->scratches[0].profile, detail.scratches[0].profile);
  detail.phases[1].sheets.width = 0;
  const std::vector<char> damaged = bytes_of_lines(detail);
  EXPECT_EQ(test::code_of([&] {
              Reader r(damaged.data(), damaged.size());
              value_type<Detail>().decode(r);
            }),
            "damaged");
}

// Sheets of thickness t and area S per volume fill the volume S·t, and so the share L·w of a section, where
// its lines are longer than S by π/4 and wider than t by 4/π.
TEST(SheetField, HasTheDensityOfItsLines) {
  Detail::Sheets sheets;
  sheets.length = 15;
  sheets.width = 1;
  sheets.density = 0.01f;
  sheets.bend = 0.3f;
  const residual::SheetField field(Vec3::Constant(160), sheets, 2, 1, 5);
  for (const float relative : {1.0f, 2.0f}) {
    double sum = 0, count = 0;
    for (int z = 0; z < 40; ++z)
      for (int y = 0; y < 160; ++y)
        for (int x = 0; x < 160; ++x) {
          sum += field.at({x + 0.5f, y + 0.5f, 4 * z + 0.3f}, relative);
          ++count;
        }
    // A Gaussian profile of deviation w covers w·√(2π); where sheets cross, they count once.
    const double expected = relative * sheets.density * std::sqrt(2 * std::numbers::pi) * sheets.width;
    EXPECT_NEAR(sum / count, expected, 0.12 * expected);
  }
}

TEST(SheetField, Repeats) {
  Detail::Sheets sheets;
  sheets.length = 12;
  sheets.width = 1;
  sheets.density = 0.02f;
  const residual::SheetField field(Vec3(64, 80, 96), sheets, 1, 1, 5);
  int shown = 0;
  for (int i = 0; i < 2000; ++i) {
    Random random(9, 1, static_cast<std::uint64_t>(i));
    const Vec3f p(static_cast<float>(random.uniform(0, 64)), static_cast<float>(random.uniform(0, 80)),
                  static_cast<float>(random.uniform(0, 96)));
    EXPECT_NEAR(field.at(p, 1), field.at(p + Vec3f(64, -80, 96), 1), 1e-3f);
    shown += field.at(p, 1) > 0.5f;
  }
  EXPECT_GT(shown, 20);
}

}  // namespace
}  // namespace terrazzo

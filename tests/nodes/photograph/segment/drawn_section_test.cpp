// Complete synthetic sections: the area fraction and the particles must be recovered for any contrast, blur,
// noise, sizes and gaps.
#include <gtest/gtest.h>

#include <functional>

#include "nodes/photograph/segment/segment.h"
#include "tests/nodes/photograph/segment/drawn_section.h"
#include "tests/nodes/photograph/segment/synthetic_section.h"

namespace terrazzo {
namespace {
using namespace segment;

using test::DrawnOptions;

struct Case {
  const char* name;
  std::function<void(DrawnOptions&)> set;
  double area = 0.03;       // allowed relative error of the area fraction
  double precision = 0.93;  // minimum average precision at an overlap of one half
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class DrawnSections : public testing::TestWithParam<Case> {};

TEST_P(DrawnSections, AreaFractionAndParticlesComeBack) {
  for (const std::uint64_t seed : {1, 2}) {
    DrawnOptions options;
    options.side = 192;
    options.seed = seed;
    GetParam().set(options);
    const auto drawn = test::draw_section(options);
    const Segmentation s = segment::segment(drawn.image, {}, {});
    EXPECT_TRUE(s.method == Method::Clusters || s.method == Method::Both);  // color decides what is binder
    EXPECT_NEAR(s.profiles.area_fraction / drawn.area_fraction, 1, GetParam().area) << "seed " << seed;
    EXPECT_GE(test::average_precision(drawn.labels, s.labels.ids), GetParam().precision) << "seed " << seed;
  }
}

const std::vector<Vec3f> seven = {{0.1f, 0.05f, 0.03f}, {0.45f, 0.2f, 0.05f}, {0.05f, 0.1f, 0.2f},
                                  {0.93f, 0.92f, 0.9f}, {0.3f, 0.3f, 0.28f},  {0.2f, 0.3f, 0.2f},
                                  {0.6f, 0.35f, 0.05f}};

void gray(DrawnOptions& o, float particle, float binder) {
  o.palette = {Vec3f::Constant(particle)};
  o.binder = Vec3f::Constant(binder);
  o.signal = true;
  o.vary = 0.03f;
}

INSTANTIATE_TEST_SUITE_P(
    Segment, DrawnSections,
    testing::Values(
        Case{"dense", [](DrawnOptions&) {}, 0.02},
        Case{"dense_blurred_and_noisy", [](DrawnOptions& o) { o.blur = 1.2f, o.noise = 0.03f; }},
        Case{"thin_gaps", [](DrawnOptions& o) { o.gap = 3; }, 0.02},
        Case{"thin_noisy_gaps", [](DrawnOptions& o) { o.gap = 3, o.noise = 0.02f; }, 0.02},
        Case{"small", [](DrawnOptions& o) { o.spacing = 22, o.gap = 5; }},
        Case{"tiny_and_dense", [](DrawnOptions& o) { o.spacing = 14, o.gap = 4; }, 0.04},
        Case{"tiny_and_sparse", [](DrawnOptions& o) { o.spacing = 14, o.gap = 4, o.keep = 0.4; }, 0.04},
        Case{"seven_colors_one_near_the_binder", [](DrawnOptions& o) { o.palette = seven, o.keep = 0.6; }},
        Case{"seven_colors_mottled",
             [](DrawnOptions& o) { o.palette = seven, o.keep = 0.6, o.mottle = 0.05f, o.noise = 0.01f; }},
        Case{"gray_of_low_contrast", [](DrawnOptions& o) { gray(o, 0.3f, 0.2f), o.mottle = 0.02f; }},
        Case{"gray_of_low_contrast_noisy", [](DrawnOptions& o) { gray(o, 0.3f, 0.2f), o.noise = 0.02f; }},
        Case{"light_in_dark_blurred", [](DrawnOptions& o) { gray(o, 0.5f, 0.03f), o.blur = 1.5f; }, 0.04,
             0.9},
        Case{"dark_in_light_thin", [](DrawnOptions& o) { gray(o, 0.04f, 0.6f), o.gap = 3.5; }},
        Case{"uneven_light", [](DrawnOptions& o) { o.light = 0.5f, o.keep = 0.7; }}),
    [](const testing::TestParamInfo<Case>& info) { return std::string(info.param.name); });

// Few particles in very noisy binder: only they are found.
TEST(Segment, SparseDiscsInGreyNoise) {
  for (const std::uint64_t seed : {1, 2}) {
    const auto discs = test::scatter(240, 240, 10, 6, 24, seed, 10);
    Image image(240, 240, 1, 1, Vec3f::Constant(0.6f));
    for (const auto& d : discs) test::draw(image, d, Vec3f::Constant(0.1f));
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      image.pixels[i] =
          srgb_to_linear(linear_to_srgb(image.pixels[i]) +
                         Vec3f::Constant(0.02f * static_cast<float>(Random(seed, 9, i).normal())));
    const Segmentation s = segment::segment(image, {}, {});
    EXPECT_EQ(s.profiles.profiles.size(), discs.size());
    double area = 0;
    for (const auto& d : discs) area += std::numbers::pi * d.radius * d.radius;
    EXPECT_NEAR(s.profiles.area_fraction * 240 * 240, area, 0.02 * area);
  }
}

// No binder between most particles: a result or an error, never a crash.
TEST(Segment, ParticlesWithoutBinder) {
  DrawnOptions options;
  options.side = 96;
  options.gap = 0;
  try {
    segment::segment(test::draw_section(options).image, {}, {});
  } catch (const std::exception& e) {
    EXPECT_NE(std::string(e.what()), "");
  }
}

}  // namespace
}  // namespace terrazzo

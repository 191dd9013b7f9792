// Phases of micrographs: noise, uneven light, number of phases, bad input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/media/micrograph/find_phases.h"
#include "nodes/media/micrograph/structure.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace media;

constexpr int kSide = 96;

// Wide bands that wind, `phases` of them in turn.
int phase_at(int x, int y, int phases) {
  const double v =
      std::sin(0.11 * x + 0.6 * std::sin(0.07 * y)) + std::sin(0.13 * y + 0.5 * std::sin(0.05 * x));
  return std::clamp(static_cast<int>((v + 2) / 4 * phases), 0, phases - 1);
}

// Encoded gray levels from 0.2 to 0.8, noise of this standard deviation, and light that falls by `fall` to
// the right.
Image picture(int phases, double noise, double fall, std::uint64_t seed = 1) {
  Image out(kSide, kSide, 1, 0.1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      Random r(seed, 1, y * kSide + x);
      const double gray =
          0.2 + 0.6 * phase_at(x, y, phases) / (phases - 1) + noise * r.normal() - fall * x / kSide;
      out.at(x, y) = Vec3f::Constant(static_cast<float>(std::pow(std::clamp(gray, 0.0, 1.0), 2.2)));
    }
  return out;
}

double wrong(const PhaseMap& map, int phases) {
  int n = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) n += map.at[map.index(x, y)] != phase_at(x, y, phases);
  return n / double(kSide * kSide);
}

TEST(Phases, AreFoundInSpiteOfNoiseAndLight) {
  for (const int phases : {2, 3, 4}) {
    const double step = 0.6 / (phases - 1);
    const auto clean = find_phases(picture(phases, 0, 0), {}, {}, {});
    EXPECT_EQ(clean.map.phases, phases);
    EXPECT_EQ(wrong(clean.map, phases), 0);
    EXPECT_LT(clean.uncertain, 1e-6);
    PhaseOptions options;
    options.phases = phases;
    const auto noisy = find_phases(picture(phases, 0.3 * step, 0.15), {}, options, {});
    EXPECT_LT(wrong(noisy.map, phases), 0.03) << phases;
    EXPECT_GT(noisy.shading, 0.05);
    EXPECT_GT(noisy.uncertain, 0);
    EXPECT_LT(noisy.separation, clean.separation);
    // Thresholds alone are wrong at many pixels.
    options.smoothing = 0;
    options.shading = false;
    EXPECT_GT(wrong(find_phases(picture(phases, 0.3 * step, 0.15), {}, options, {}).map, phases),
              3 * wrong(noisy.map, phases))
        << phases;
  }
}

TEST(Phases, SinglePixelsOfACleanPictureRemain) {
  Image image = picture(2, 0, 0);
  const Vec3f dark = Vec3f::Constant(static_cast<float>(std::pow(0.2, 2.2))),
              light = Vec3f::Constant(static_cast<float>(std::pow(0.8, 2.2)));
  for (const int at : {1000, 3000, 7000}) {
    Vec3f& p = image.pixels[at];
    p = (p - dark).norm() < 0.01f ? light : dark;
  }
  const auto found = find_phases(image, {}, {}, {});
  EXPECT_NEAR(wrong(found.map, 2), 3.0 / (kSide * kSide), 1e-9);
}

TEST(Phases, ColorsTellPhasesOfEqualLightness) {
  Image image(kSide, kSide, 1, 1);
  const Vec3f a(0.30f, 0.10f, 0.10f), b(0.05f, 0.17f, 0.10f);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) image.at(x, y) = phase_at(x, y, 2) ? a : b;
  const auto found = find_phases(image, {}, {}, {});
  EXPECT_EQ(found.map.phases, 2);
  const double error = wrong(found.map, 2);
  EXPECT_EQ(std::min(error, 1 - error), 0);
}

TEST(Phases, TheNodeReportsWhatItFound) {
  Labels mask;
  mask.width = mask.height = kSide;
  mask.ids.assign(kSide * kSide, 0);
  for (int i = 0; i < 10 * kSide; ++i) mask.ids[i] = 1;
  mask.classes = {0};
  const auto run =
      test::run_node("Phases", {{"image", Value::of(picture(3, 0.02, 0))}, {"mask", Value::of(mask)}});
  EXPECT_EQ(run.metrics.at("phases"), 3);
  const Labels& labels = run.output<Labels>("labels");
  EXPECT_EQ(labels.classes, (std::vector<std::int32_t>{0, 1}));
  double sum = 0;
  for (const char* f : {"fraction_0", "fraction_1", "fraction_2"}) sum += run.metrics.at(f);
  EXPECT_NEAR(sum, 1, 1e-12);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) EXPECT_EQ(labels.ids[labels.index(x, y)], y < 10 ? 0 : phase_at(x, y, 3));
}

// A flat strip with blocks like letters below the micrograph is no phase.
TEST(Phases, ACaptionDoesNotCount) {
  const auto data = test::shared_data();
  if (data.empty()) GTEST_SKIP() << "no shared data";
  const auto image = test::run_node("LoadImage", {}, {{"path", (data / "reports/sem_strip.jpg").string()}});
  const auto run =
      test::run_node("Phases", {{"image", Value::of(image.output<Image>("image"))}}, {{"phases", "2"}});
  ASSERT_FALSE(run.warnings.empty());
  EXPECT_NE(run.warnings[0].find("rows 650 to 719 show a caption"), std::string::npos) << run.warnings[0];
  const Labels& unobserved = run.output<Labels>("unobserved");
  EXPECT_EQ(std::count(unobserved.ids.begin(), unobserved.ids.end(), 1), 900 * 70);
  EXPECT_EQ(run.output<Labels>("labels").ids.back(), 0);
}

TEST(Phases, BadPicturesAreErrors) {
  const auto code = [](const Image& image) { return test::code_of([&] { find_phases(image, {}, {}, {}); }); };
  EXPECT_EQ(code(Image(40, 40, 1, 1, Vec3f::Constant(0.3f))), "one-phase");
  Image noise(kSide, kSide, 1, 1);
  for (std::size_t i = 0; i < noise.pixels.size(); ++i)
    noise.pixels[i] =
        Vec3f::Constant(static_cast<float>(std::clamp(0.4 + 0.05 * Random(2, 1, i).normal(), 0.0, 1.0)));
  EXPECT_EQ(code(noise), "one-phase");
  EXPECT_EQ(code(Image()), "empty-image");
  Image bad = picture(2, 0, 0);
  bad.at(3, 4).x() = std::nanf("");
  EXPECT_EQ(code(bad), "bad-pixels");
  EXPECT_EQ(test::code_of(
                [] { find_phases(picture(2, 0, 0), std::vector<std::uint8_t>(kSide * kSide, 1), {}, {}); }),
            "empty-image");
}

TEST(Phases, StructureHasADirectionAndASize) {
  PhaseMap stripes{60, 60, 2, 1, {}}, checks{60, 60, 2, 1, {}};
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) {
      stripes.at.push_back(x / 5 % 2);
      checks.at.push_back((x / 5 + y / 5) % 2);
    }
  EXPECT_NEAR(directedness(stripes), 1, 1e-9);
  EXPECT_LT(directedness(checks), 0.05);
  // Covariance of checks of five pixels falls from 1/2 to −1/2 along the axes: to 1/e of 1/2 after 3.2
  // pixels.
  EXPECT_NEAR(correlation_length(checks), 2.5 * (1 - 1 / std::exp(1.0)), 0.2);
}

}  // namespace
}  // namespace terrazzo

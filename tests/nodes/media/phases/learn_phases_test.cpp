// Phases by example: strokes tell what gray levels cannot.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/common/texture/pixel_forest.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/media/micrograph/learn_phases.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace media;

constexpr int kEdge = 128;

int true_phase(int x, int y) {
  const double v =
      std::sin(0.09 * x + 0.6 * std::sin(0.05 * y)) + std::sin(0.1 * y + 0.5 * std::sin(0.04 * x));
  return std::clamp(static_cast<int>((v + 2) / 4 * 3), 0, 2);
}

// Phases 0 and 1 have the same mean gray, but 1 is rough. Phase 2 is lighter.
Image rough_and_smooth() {
  Image out(kEdge, kEdge, 1, 0.1);
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) {
      Random r(1, 2, pixel_at(x, y, kEdge));
      const double mean[3] = {0.4, 0.4, 0.6}, noise[3] = {0.01, 0.08, 0.01};
      const int p = true_phase(x, y);
      out.at(x, y) = Vec3f::Constant(static_cast<float>(std::pow(mean[p] + noise[p] * r.normal(), 2.2)));
    }
  return out;
}

// Dabs where a phase surrounds them.
Strokes dabs(int phase, int count) {
  Strokes out;
  for (int k = 0; count_of(out.strokes) < count; ++k) {
    Random r(3, phase, k);
    const int x = 8 + static_cast<int>(r.below(kEdge - 16)), y = 8 + static_cast<int>(r.below(kEdge - 16));
    bool inside = true;
    for (int i = 0; i < 81; ++i) inside = inside && true_phase(x + i % 9 - 4, y + i / 9 - 4) == phase;
    if (inside) out.strokes.push_back({{{Vec2(x + 0.5, y + 0.5)}}, 3, false});
  }
  return out;
}

double wrong_share(const PhaseMap& map) {
  int n = 0;
  for (int y = 0; y < kEdge; ++y)
    for (int x = 0; x < kEdge; ++x) n += map.at[map.index(x, y)] != true_phase(x, y);
  return n / double(kEdge * kEdge);
}

TEST(LearnPhases, StrokesTellPhasesOfEqualGray) {
  const Image image = rough_and_smooth();
  const Strokes taught[3] = {dabs(0, 6), dabs(1, 6), dabs(2, 6)};
  const auto found = learn_phases(image, {}, {&taught[0], &taught[1], &taught[2]}, 1, 1, {});
  EXPECT_LT(wrong_share(found.map), 0.1);
  PhaseOptions by_gray;
  by_gray.phases = 3;
  EXPECT_GT(wrong_share(find_phases(image, {}, by_gray, {}).map), 0.2);
  for (int k = 0; k < 3; ++k)
    for (const Stroke& s : taught[k].strokes)
      EXPECT_EQ(
          found.map
              .at[found.map.index(static_cast<int>(s.parts[0][0].x()), static_cast<int>(s.parts[0][0].y()))],
          k);
  // The order of the strokes numbers the phases.
  const auto turned = learn_phases(image, {}, {&taught[2], &taught[0], &taught[1]}, 1, 1, {});
  EXPECT_GT(turned.level[0], turned.level[1] + 0.1);
  EXPECT_GE(turned.separation, 0);
  EXPECT_LT(turned.separation, 0.5);  // two phases of one gray
}

TEST(LearnPhases, TheNodeTakesStrokesOfEachPhase) {
  const Image image = rough_and_smooth();
  Labels mask;
  mask.width = mask.height = kEdge;
  mask.ids.assign(kEdge * kEdge, 0);
  std::fill_n(mask.ids.begin(), 4 * kEdge, 1);
  mask.classes = {0};
  const auto run = [&](const std::string& phases) {
    return test::run_node("Phases",
                          {{"image", Value::of(image)},
                           {"mask", Value::of(mask)},
                           {"strokes", Value::of(dabs(0, 6))},
                           {"strokes", Value::of(dabs(1, 6))},
                           {"strokes", Value::of(dabs(2, 6))}},
                          {{"phases", phases}});
  };
  const auto result = run("auto");
  EXPECT_EQ(result.metrics.at("phases"), 3);
  EXPECT_TRUE(result.warnings.empty());
  const Labels& unobserved = result.output<Labels>("unobserved");
  EXPECT_EQ(std::count(unobserved.ids.begin(), unobserved.ids.end(), 1), 4 * kEdge);
  EXPECT_EQ(test::code_of([&] { run("2"); }), "bad-value");
}

TEST(LearnPhases, StrokesOnEachOfTwoPhasesAreNeeded) {
  const Image image = rough_and_smooth();
  const Strokes some = dabs(0, 3), none;
  Strokes outside;
  outside.strokes.push_back({{{Vec2(-50, -50)}}, 3, false});
  const auto code = [&](const std::vector<const Strokes*>& strokes) {
    return test::code_of([&] { learn_phases(image, {}, strokes, 1, 1, {}); });
  };
  EXPECT_EQ(code({&some}), "wrong-count");
  EXPECT_EQ(code({&some, &none}), "no-strokes");
  EXPECT_EQ(code({&some, &outside}), "no-strokes");
  // The last of overlapping strokes counts, and ignored pixels teach nothing.
  EXPECT_EQ(code({&some, &some}), "no-strokes");
  const Strokes other = dabs(1, 3);
  std::vector<std::uint8_t> ignored(kEdge * kEdge, 0);
  for (const std::uint32_t at : stroked_pixels(&other, kEdge, kEdge)) ignored[at] = 1;
  EXPECT_EQ(test::code_of([&] { learn_phases(image, ignored, {&some, &other}, 1, 1, {}); }), "no-strokes");
}

}  // namespace
}  // namespace terrazzo

// Tone mapping by OpenColorIO.
#include "nodes/bodies/render_solid/tone.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "nodes/common/texture/color.h"
#include "nodes/data/shapes.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace render_solid;

Image one(const Vec3f& v) {
  Image i(1, 1, 1, 1);
  i.pixels[0] = v;
  return i;
}

Vec3f shown(const Tone& tone, const Vec3f& v) {
  Image i = one(v);
  tone.apply(i);
  return i.pixels[0];
}

std::string failure(ToneKind kind, const std::string& view = "") {
  return test::code_of([&] { const Tone tone(kind, view); });
}

// Sets $OCIO for its lifetime.
class WithConfig {
 public:
  explicit WithConfig(const std::string& text) {
    const auto path = test::temporary_folder() / "tone.ocio";
    std::ofstream(path) << text;
    setenv("OCIO", path.c_str(), 1);
  }
  ~WithConfig() { unsetenv("OCIO"); }
};

constexpr const char* config = R"(ocio_profile_version: 2
roles: {default: raw, scene_linear: lin_rec709}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays:
  Monitor / office: [!<View> {name: Plain, colorspace: srgb}, !<View> {name: Half, colorspace: half}]
  Wall: [!<View> {name: Plain, colorspace: half}]
colorspaces:
  - !<ColorSpace> {name: lin_rec709}
  - !<ColorSpace> {name: srgb, to_reference: !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055}}
  - !<ColorSpace> {name: half, from_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}}
  - !<ColorSpace> {name: raw, isdata: true}
)";

TEST(Tone, NeutralIsTheCurve) {
  const Tone tone(ToneKind::Neutral);
  for (std::uint64_t k = 0; k < 2000; ++k) {
    Random r(1, 1, k);
    const double strong = k % 2 ? 2 : 0.85;
    const Vec3f v =
        Vec3f(float(r.uniform(0, strong)), float(r.uniform(0, strong)), float(r.uniform(0, strong)));
    EXPECT_LT((shown(tone, v) - neutral_curve(v)).cwiseAbs().maxCoeff(), k % 2 ? 1.0f / 400 : 2e-6f);
  }
  EXPECT_GT(shown(tone, Vec3f::Constant(50)).minCoeff(), 0.999f);
  EXPECT_EQ(shown(tone, Vec3f::Constant(-1)), Vec3f(Vec3f::Zero()));
}

TEST(Tone, NoneLeavesLightAsItIs) {
  EXPECT_EQ(shown(Tone(ToneKind::None), Vec3f(3, -1, 0.5f)), Vec3f(3, -1, 0.5f));
}

TEST(Tone, AViewOfTheConfiguration) {
  EXPECT_EQ(failure(ToneKind::View), "no-color-config");
  const WithConfig with(config);
  const Vec3f v(0.2f, 0.5f, 0.9f);
  // The PNG's values are those of the view.
  EXPECT_LT((linear_to_srgb(shown(Tone(ToneKind::View), v)) - linear_to_srgb(v)).norm(), 1e-4f);
  for (const std::string name : {"Half", "Monitor / office/Half", "Wall/Plain"})
    EXPECT_LT((linear_to_srgb(shown(Tone(ToneKind::View, name), v)) - 0.5f * v).norm(), 1e-4f) << name;
  EXPECT_EQ(failure(ToneKind::View, "Film"), "unknown-view");
  EXPECT_EQ(failure(ToneKind::View, "Wall/Half"), "unknown-view");
}

TEST(Tone, AConfigurationThatCannotBeUsed) {
  {
    const WithConfig with("nonsense: [");
    EXPECT_EQ(failure(ToneKind::View), "color-config");
    EXPECT_EQ(failure(ToneKind::Neutral), "");
  }
  const std::string other = config;
  const std::size_t at = other.find("  - !<ColorSpace> {name: lin_rec709}\n");
  std::string without = other;
  without.replace(at, 37, "  - !<ColorSpace> {name: linear_of_another_kind}\n");
  without.replace(without.find("scene_linear: lin_rec709"), 24, "scene_linear: linear_of_another_kind");
  const WithConfig with(without);
  EXPECT_EQ(failure(ToneKind::View), "color-config");
}

}  // namespace
}  // namespace terrazzo

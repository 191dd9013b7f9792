// The shader's pictures compared with the processor's, on Mesa's software renderer.
#include <gtest/gtest.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/texture/noise.h"
#include "nodes/volumes/render_volume/gl_march.h"

namespace terrazzo::render_volume {
namespace {
using namespace render_volume;

Scene scene_of(const Look& look, bool textures) {
  const Vec3i n(40, 33, 21);
  std::vector<float> v;
  for (int z = 0; z < n.z(); ++z)
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x) {
        const Vec3 p(x, y, 2.0 * z);
        const double r = (p - Vec3(20, 16, 21)).norm() + 4 * noise(1, p * 0.2);
        v.push_back(static_cast<float>(r > 17 ? -1000 : r > 15 ? -250 : r > 13 ? -100 : r > 5 ? 50 : 900));
      }
  std::vector<SolidTexture> all;
  for (std::uint64_t seed = 1; textures && seed <= 3; ++seed) {
    std::vector<Vec3f> c;
    for (int i = 0; i < 17 * 17 * 17; ++i) {
      const auto w = static_cast<float>(noise(seed, Vec3(i % 17, i / 17 % 17, i / 289) * 0.3));
      c.push_back(Vec3f(0.5f + 0.3f * w, 0.4f, 0.3f - 0.2f * w));
    }
    all.emplace_back(Vec3i(17, 17, 17), 0.4f, c);
  }
  return Scene(scan_field(n, Vec3(1, 1, 2), v),
               parse_tissues({"skin -600 -190 #d9a58c noise opacity=0.25", "fat -190 -30 #ead9a9 texture",
                              "muscle -30 150 #8f3a36 texture", "bone 150 4000 #efe6cf texture"}),
               all, look);
}

TEST(GlMarch, PicturesEqualTheProcessors) {
  try {
    EglContext probe(GlDevice::Cpu);
  } catch (const Error& e) {
    GTEST_SKIP() << e.what();
  }
  Look look;
  look.width = 96;
  look.height = 70;
  for (int k = 0; k < 5; ++k) {
    look.clip = {Vec3f::Zero(), Vec3f::Ones()};
    if (k % 2) look.clip = {Vec3f(0, 0, 0.1f), Vec3f(0.6f, 1, 0.5f)};
    look.samples = 1 + k % 2;
    look.up = k % 3;
    look.elevation = 60 * k - 80;
    look.seed = 7 + k;
    look.opacity = k == 3 ? 0.05 : 1;
    look.skip_empty = k != 4;
    const Scene scene = scene_of(look, k > 0);
    const Bricks bricks(scene.scan, scene.intervals);
    const Frame frame = frame_of(scene, 70 * k);
    FrameCounts ours, theirs;
    const auto a = march(scene, frame, bricks, ours);
    GlMarcher gl(scene, bricks, GlDevice::Cpu);
    const auto b = gl.march(frame, theirs);
    ASSERT_EQ(a.size(), b.size());
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).cwiseAbs().sum() / 3;
    EXPECT_LT(sum / double(a.size()), 1.0 / 1000) << k;
    EXPECT_NEAR(double(ours.samples), double(theirs.samples), 0.01 * double(ours.samples));
    EXPECT_NEAR(double(ours.lookups), double(theirs.lookups), 0.01 * double(ours.lookups));
    EXPECT_EQ(gl.march(frame, theirs), b) << "a second frame of one scene";
  }
}

TEST(GlMarch, AContextGivesWayToOneWithin) {
  try {
    EglContext probe(GlDevice::Cpu);
  } catch (const Error& e) {
    GTEST_SKIP() << e.what();
  }
  Look look;
  look.width = 40;
  look.height = 24;
  const Scene scene = scene_of(look, false);
  const Bricks bricks(scene.scan, scene.intervals);
  const Frame frame = frame_of(scene, 20);
  FrameCounts counts;
  GlMarcher outer(scene, bricks, GlDevice::Cpu);
  const auto before = outer.march(frame, counts);
  {
    GlMarcher inner(scene, bricks, GlDevice::Cpu);
    EXPECT_EQ(inner.march(frame, counts), before);
  }
  EXPECT_NE(outer.march(frame_of(scene, 90), counts), before);
  EXPECT_EQ(outer.march(frame, counts), before);
}

TEST(GlMarch, RefusesWhatTheShaderHasNoRoomFor) {
  try {
    EglContext probe(GlDevice::Cpu);
  } catch (const Error& e) {
    GTEST_SKIP() << e.what();
  }
  Look look;
  look.width = look.height = 8;
  std::vector<SolidTexture> many;
  std::vector<std::string> classes;
  for (int i = 0; i < 13; ++i) {
    many.emplace_back(Vec3i(1, 1, 1), 1, std::vector<Vec3f>{Vec3f::Ones()});
    classes.push_back("c" + std::to_string(i) + " " + std::to_string(i) + " " + std::to_string(i + 1) +
                      " texture");
  }
  const Scene scene(scan_field(Vec3i(2, 2, 2), Vec3::Ones(), {0, 1, 2, 3, 4, 5, 6, 7}),
                    parse_tissues(classes), many, look);
  const Bricks bricks(scene.scan, scene.intervals);
  try {
    GlMarcher gl(scene, bricks, GlDevice::Cpu);
    ADD_FAILURE() << "13 textures fit";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "too-large-for-gl");
  }
}

}  // namespace
}  // namespace terrazzo::render_volume

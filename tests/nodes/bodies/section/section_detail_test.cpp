// Sections with the fine detail of a photograph.
#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/detail.h"
#include "nodes/data/image.h"
#include "nodes/data/labels.h"
#include "nodes/data/particles.h"
#include "nodes/data/shapes.h"
#include "runtime/random.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

struct Packing {
  Particles particles;
  Shapes shapes;
};

Packing three_cubes() {
  Packing p;
  p.shapes.shapes = {measure_shape("cube", test::cube_mesh())};
  p.particles.box = Vec3(12, 10, 8);
  p.particles.resize(3);
  p.particles.position = {Vec3(2, 3, 2), Vec3(7, 7, 4), Vec3(11.5, 5, 6)};
  p.particles.scale = {2, 3, 2.5};
  p.particles.size = {2.2, 3.3, 2.8};
  p.particles.color.assign(3, Vec3f::Constant(0.1f));
  p.particles.binder_color = Vec3f::Constant(0.5f);
  return p;
}

Detail noise() {
  Detail d;
  d.pixel_size = 0.1;
  d.size = 16;
  for (std::uint64_t k = 0; k < 2; ++k) {
    Detail::Phase phase;
    for (std::uint64_t i = 0; i < 16 * 16 * 16; ++i)
      phase.tile.push_back(Vec3f::Constant(static_cast<float>(0.05 * Random(1, k, i).normal())));
    d.phases.push_back(std::move(phase));
  }
  return d;
}

test::NodeRun cut(const Packing& p, std::multimap<std::string, Value> more,
                  const std::map<std::string, std::string>& parameters) {
  more.emplace("particles", Value::of(p.particles));
  more.emplace("shapes", Value::of(p.shapes));
  return test::run_node("Section", more, parameters);
}

TEST(SectionDetail, ChangesTheImageOnly) {
  const Packing p = three_cubes();
  const std::map<std::string, std::string> parameters = {
      {"axis", "random"}, {"planes", "3"}, {"pixel_size", "0.1"}};
  const auto flat = cut(p, {}, parameters), shown = cut(p, {{"detail", Value::of(noise())}}, parameters);
  EXPECT_EQ(flat.output<Labels>("labels").ids, shown.output<Labels>("labels").ids);
  EXPECT_EQ(flat.metrics.at("area_fraction"), shown.metrics.at("area_fraction"));
  const Image &a = flat.output<Image>("image"), &b = shown.output<Image>("image");
  ASSERT_EQ(a.pixels.size(), b.pixels.size());
  std::size_t changed = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    ASSERT_TRUE(b.pixels[i].allFinite());
    changed += a.pixels[i] != b.pixels[i];
  }
  EXPECT_GT(changed, a.pixels.size() * 9 / 10);
}

TEST(SectionDetail, APlaneIsTheSameAloneAndAmongOthers) {
  const Packing p = three_cubes();
  const Value detail = Value::of(noise());
  const auto all =
      cut(p, {{"detail", detail}}, {{"axis", "z"}, {"offsets", "[1.3, 4, 6.2]"}, {"pixel_size", "0.1"}});
  const auto one = cut(p, {{"detail", detail}}, {{"axis", "z"}, {"offsets", "[4]"}, {"pixel_size", "0.1"}});
  const Image &whole = all.output<Image>("image"), &plane = one.output<Image>("image");
  ASSERT_EQ(whole.pixels.size(), 3 * plane.pixels.size());
  for (std::size_t i = 0; i < plane.pixels.size(); ++i)
    ASSERT_EQ(whole.pixels[plane.pixels.size() + i], plane.pixels[i]);
}

TEST(SectionDetail, TakesTheExtentOfAPicture) {
  const Packing p = three_cubes();
  const Value like = Value::of(Image(70, 40, 1, 0.05));
  const auto random = cut(p, {{"like", like}}, {{"axis", "random"}});
  EXPECT_EQ(random.output<Image>("image").width, 70);
  EXPECT_EQ(random.output<Image>("image").height, 40);
  EXPECT_NEAR(random.output<Image>("image").pixel_size, 0.05, 1e-9);
  const auto axis = cut(p, {{"like", like}}, {{"axis", "z"}});  // a whole face, with pixels of this size
  EXPECT_EQ(axis.output<Image>("image").width, 240);
  const auto chosen = cut(p, {{"like", like}}, {{"axis", "random"}, {"width", "2"}, {"pixel_size", "0.1"}});
  EXPECT_EQ(chosen.output<Image>("image").width, 20);
  EXPECT_EQ(chosen.output<Image>("image").height, 20);
  const auto large = cut(p, {{"like", Value::of(Image(2000, 1200, 1, 0.01))}}, {{"axis", "random"}});
  EXPECT_EQ(large.output<Image>("image").width, 1024);
  EXPECT_EQ(large.output<Image>("image").height, 1024);
}

TEST(SectionDetail, SoftnessBlursOutlines) {
  const Packing p = three_cubes();
  Detail d = noise();
  for (auto& phase : d.phases)
    for (Vec3f& v : phase.tile) v.setZero();
  const auto steepest = [&](double softness) {
    d.softness = softness;
    const auto run =
        cut(p, {{"detail", Value::of(d)}}, {{"axis", "z"}, {"offsets", "[2]"}, {"pixel_size", "0.1"}});
    const Image& image = run.output<Image>("image");
    float most = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 1; x < image.width; ++x)
        most = std::max(most, std::abs(image.at(x, y).x() - image.at(x - 1, y).x()));
    return most;
  };
  // A blur with a deviation of 2 pixels spreads a step over several pixels: the steepest is 1/(2·√(2π)) of
  // it.
  const float sharp = steepest(0), soft = steepest(2);
  EXPECT_NEAR(sharp, 0.4f, 0.01f);
  EXPECT_NEAR(soft, 0.4f / (2 * std::sqrt(2 * 3.14159f)), 0.01f);
}

}  // namespace
}  // namespace terrazzo

// ShapeEstimate with class: each, and what KMatrix and Unfold make of its shapes.
#include <gtest/gtest.h>

#include "nodes/data/kmatrix.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/data/size_distribution.h"
#include "runtime/codec.h"
#include "runtime/random.h"
#include "tests/nodes/shapes/shape_estimate/synthetic_profiles.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
namespace made = shape_estimate::test;

// Round profiles of class 0 and long ones of class 1.
Profiles two_classes(int round, int longish) {
  Random r(5);
  std::vector<made::Contour> contours;
  for (int i = 0; i < round; ++i) {
    const double size = r.uniform(0.8, 1.2);
    contours.push_back(made::ellipse(size, size * r.uniform(0.9, 1)));
  }
  for (int i = 0; i < longish; ++i) {
    const double size = r.uniform(0.8, 1.2);
    contours.push_back(made::ellipse(3 * size, size * r.uniform(0.9, 1)));
  }
  Profiles p = made::profiles_of(contours);
  for (std::size_t i = round; i < p.profiles.size(); ++i) p.profiles[i].cls = 1;
  p.classes = longish > 0 ? 2 : 1;
  return p;
}

Shapes estimate(const Profiles& p, const std::string& cls) {
  const std::map<std::string, std::string> how{
      {"method", "morphed_generalized_cylinder"}, {"count", "2"}, {"class", cls}};
  return test::run_node("ShapeEstimate", {{"profiles", Value::of(p)}}, how).output<Shapes>("shapes");
}

void expect_equal(const Shape& a, const Shape& b) {
  ASSERT_EQ(a.mesh.vertices.size(), b.mesh.vertices.size());
  for (std::size_t i = 0; i < a.mesh.vertices.size(); ++i) EXPECT_EQ(a.mesh.vertices[i], b.mesh.vertices[i]);
}

TEST(ShapeEstimateEachClass, EveryClassGetsTheShapesOfItsOwnProfiles) {
  const Profiles p = two_classes(30, 20);
  const Shapes each = estimate(p, "each"), first = estimate(p, "0"), second = estimate(p, "1");
  ASSERT_EQ(each.shapes.size(), 4u);
  double sum = 0;
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(each.shapes[k].cls, k / 2);
    EXPECT_NEAR(each.shapes[k].probability, k < 2 ? 0.3 : 0.2, 1e-12);
    expect_equal(each.shapes[k], k < 2 ? first.shapes[k] : second.shapes[k - 2]);
    sum += each.shapes[k].probability;
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(ShapeEstimateEachClass, OneClassHasShapesForAny) {
  const Profiles p = two_classes(30, 0);
  const Shapes each = estimate(p, "each"), any = estimate(p, "any");
  ASSERT_EQ(each.shapes.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(each.shapes[k].cls, -1);
    EXPECT_EQ(each.shapes[k].probability, any.shapes[k].probability);
    expect_equal(each.shapes[k], any.shapes[k]);
  }
}

TEST(ShapeEstimateEachClass, AClassOfFewProfilesGetsTheShapesOfAll) {
  const Profiles p = two_classes(30, 5);
  const Shapes each = estimate(p, "each"), any = estimate(p, "any");
  ASSERT_EQ(each.shapes.size(), 4u);
  for (int k = 2; k < 4; ++k) {
    EXPECT_EQ(each.shapes[k].cls, 1);
    expect_equal(each.shapes[k], any.shapes[k - 2]);
  }
}

TEST(ShapeEstimateEachClass, AClassOutOfRangeIsNamed) {
  Profiles p = two_classes(30, 20);
  p.profiles[3].cls = 2;
  EXPECT_EQ(test::code_of([&] { estimate(p, "each"); }), "bad-profile");
}

TEST(ShapeEstimateEachClass, ClassesSurviveStorageAndTheKMatrix) {
  const Shapes each = estimate(two_classes(30, 20), "each");
  const Value value = Value::of(each);
  BufferWriter w;
  value.type().encode(value.data(), w);
  const auto read = [&](std::size_t bytes) {
    Reader r(w.buffer.data(), bytes);
    return value.type().decode(r);
  };
  const auto again = read(w.buffer.size());
  for (int k = 0; k < 4; ++k) EXPECT_EQ(static_cast<const Shapes*>(again.get())->shapes[k].cls, k / 2);
  BufferWriter twice;
  value.type().encode(again.get(), twice);
  EXPECT_EQ(twice.buffer, w.buffer);
  EXPECT_EQ(test::code_of([&] { read(w.buffer.size() - 1); }), "damaged");

  const auto k = test::run_node("KMatrix", {{"shapes", value}}, {{"orientations", "50"}});
  ASSERT_EQ(k.output<KMatrix>("kmatrix").shapes.size(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(k.output<KMatrix>("kmatrix").shapes[i].cls, i / 2);
}

TEST(ShapeEstimateEachClass, ParticlesHaveTheShapesOfTheirClass) {
  Profiles p = two_classes(60, 40);
  p.observed_area = 4000;
  p.area_fraction = 0.1;
  const auto shapes = Value::of(estimate(p, "each"));
  const auto k =
      test::run_node("KMatrix", {{"shapes", shapes}}, {{"orientations", "100"}}).outputs.at("kmatrix");
  const auto d = test::run_node("Unfold", {{"profiles", Value::of(p)}, {"kmatrix", k}}, {{"bootstrap", "0"}});
  const auto& found = d.output<SizeDistribution>("distribution");
  ASSERT_EQ(found.shapes.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(found.shapes[i].shape, i);
    EXPECT_EQ(found.shapes[i].cls, i / 2);
  }
  p.classes = 3;
  p.profiles.back().cls = 2;  // no shape is for it
  EXPECT_EQ(test::code_of([&] {
              test::run_node("Unfold", {{"profiles", Value::of(p)}, {"kmatrix", k}}, {{"bootstrap", "0"}});
            }),
            "no-shape-of-class");
}

}  // namespace
}  // namespace terrazzo

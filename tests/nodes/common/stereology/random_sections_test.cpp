#include "nodes/common/stereology/random_sections.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/common/stereology/shape_measures.h"
#include "nodes/shapes/shape/rock.h"
#include "nodes/shapes/shape/solids.h"
#include "runtime/random.h"
#include "tests/support/meshes.h"

namespace terrazzo {
namespace {
using namespace shape;

struct Mean {
  double sum = 0, square = 0;
  int n = 0;
  void add(double v) { sum += v, square += v * v, ++n; }
  double mean() const { return sum / n; }
  double error() const { return std::sqrt((square / n - mean() * mean()) / n); }
};

// Isotropic uniform random planes: E[area] = V/H̄, E[perimeter] = πS/(4H̄).
TEST(RandomSections, MeetTheStereologicalIdentities) {
  for (int body = 0; body < 3; ++body) {
    SCOPED_TRACE(body);
    RockOptions o;
    o.axes = {1, 0.7, 0.4};
    o.roughness = 0;
    o.chips = 0;
    const Shapes s = test::one_shape(body == 0   ? box_mesh({3, 1, 0.5})
                                     : body == 1 ? ellipsoid_mesh({1, 2, 3}, 2)
                                                 : rock_mesh(o));
    Mean area, perimeter;
    for (const auto& section : random_sections(s, 6000, {SectionKind::Random, 5, 0})) {
      double a = 0, p = 0;
      for (const auto& profile : section)
        for (const auto& loop : profile) {
          a += loop_area(loop);
          p += loop_perimeter(loop);
        }
      area.add(a);
      perimeter.add(p);
    }
    const Shape& b = s.shapes[0];
    EXPECT_NEAR(area.mean(), b.volume / b.mean_caliper, 4.5 * area.error());
    EXPECT_NEAR(perimeter.mean(), M_PI * b.surface_area / (4 * b.mean_caliper), 4.5 * perimeter.error());
  }
}

TEST(RandomSections, CentralOnesPassTheCentroid) {
  const Shapes ball = test::one_shape(ellipsoid_mesh({2, 2, 2}, 3));
  for (const auto& section : random_sections(ball, 50, {SectionKind::Central, 1, 0})) {
    ASSERT_EQ(section.size(), 1u);
    EXPECT_NEAR(loop_area(section[0][0]), M_PI, 0.05);
  }
}

TEST(RandomSections, LargerBodiesAreMetMoreOften) {
  Shapes two = test::one_shape(ellipsoid_mesh({1, 1, 1}, 1));
  two.shapes.push_back(measure_shape("large", ellipsoid_mesh({3, 3, 3}, 1)));
  for (auto& s : two.shapes) s.probability = 0.5;
  int large = 0, central = 0;
  const double most = two.shapes[0].max_section_area;
  // Sections of the large ball that are larger than the small ball's largest: depths within √8 of 3.
  for (const auto& s : random_sections(two, 4000, {SectionKind::Random, 1, 0}))
    large += loop_area(s[0][0]) > most;
  for (const auto& s : random_sections(two, 4000, {SectionKind::Central, 1, 0}))
    central += loop_area(s[0][0]) > most;
  EXPECT_NEAR(large / 4000.0, 0.75 * std::sqrt(8.0) / 3, 0.03);
  EXPECT_NEAR(central / 4000.0, 0.5, 0.04);
}

TEST(RandomSections, SectionsAreNumberedNotOrdered) {
  const Shapes s = test::one_shape(box_mesh({1, 2, 3}));
  const auto all = random_sections(s, 40, {SectionKind::Random, 9, 0});
  const auto tail = random_sections(s, 20, {SectionKind::Random, 9, 20});
  for (std::size_t i = 0; i < tail.size(); ++i) EXPECT_EQ(tail[i], all[20 + i]);
}

TEST(RandomSections, FramesAreRotations) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random r(1, 2, i);
    const Vec3 u = i == 0   ? Vec3(0, 0, -1)
                   : i == 1 ? Vec3(0, 0, 1)
                            : Vec3(r.normal(), r.normal(), r.normal()).normalized();
    const Mat3 m = frame_about(u);
    EXPECT_LT((m * m.transpose() - Mat3::Identity()).norm(), 1e-12);
    EXPECT_NEAR(m.determinant(), 1, 1e-12);
    EXPECT_EQ(Vec3(m.col(2)), u);
  }
}

}  // namespace
}  // namespace terrazzo

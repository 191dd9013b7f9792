// Several shapes and color classes.
#include <gtest/gtest.h>

#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "nodes/study/unfold_study/sample_profiles.h"
#include "tests/nodes/sizes/unfold/spheres.h"
#include "tests/nodes/sizes/unfold/spheres_section.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace kmatrix;
using namespace unfolding;
using test::section;

TEST(Unfold, ColorClassesAreUnfoldedEachOnItsOwn) {
  Profiles p = section(5, 10, 0.001, 4e5, 3);
  p.classes = 2;
  for (std::size_t i = 0; i < p.profiles.size(); ++i) p.profiles[i].cls = i % 4 == 0;
  const UnfoldResult r = unfolding::unfold(p, test::spheres<10>(), {}, {});
  ASSERT_EQ(r.distribution.shapes.size(), 2u);
  double n[2] = {0, 0};
  for (const auto& e : r.distribution.shapes)
    for (const double v : e.N_V) n[e.cls] += v;
  EXPECT_NEAR(n[1] / (n[0] + n[1]), 0.25, 0.03);
}

TEST(Unfold, ShapesShareAClassByTheirProbabilities) {
  KMatrix two = test::spheres<10>();
  two.shapes[0].probability = 3;
  two.shapes.push_back(two.shapes[0]);
  two.shapes[1].probability = 1;  // the same body twice: only the shares may change
  const Profiles p = section(5, 10, 0.001, 4e5, 3);
  const UnfoldResult one = unfolding::unfold(p, test::spheres<10>(), {}, {}),
                     both = unfolding::unfold(p, two, {}, {});
  ASSERT_EQ(both.distribution.shapes.size(), 2u);
  for (std::size_t j = 0; j < 10; ++j) {
    EXPECT_NEAR(both.distribution.shapes[0].N_V[j], 0.75 * one.distribution.shapes[0].N_V[j], 1e-9);
    EXPECT_NEAR(both.distribution.shapes[1].N_V[j], 0.25 * one.distribution.shapes[0].N_V[j], 1e-9);
  }
}

TEST(Unfold, ByClassEveryClassHasItsOwnMatrix) {
  // Equation 9: class 0 has spheres, class 1 octahedra. Unfolding each separately must yield the same result.
  KMatrix k = test::spheres<10>();
  const auto solid =
      test::run_node("Shape", {}, {{"kind", "octahedron"}, {"size", "1"}}).outputs.at("shapes");
  k.shapes.push_back(make_kmatrix(solid.as<Shapes>(), {.orientations = 500}).shapes[0]);
  const Profiles one = section(5, 10, 0.001, 4e5, 3);
  Profiles p = one;
  for (Profile q : one.profiles) {
    q.cls = 1;
    p.profiles.push_back(q);
  }
  p.classes = 2;
  p.area_fraction = 2 * one.area_fraction;
  UnfoldOptions o;
  o.d_max = 10;
  o.smallest_visible = 0;
  o.types = unfolding::Types::ByClass;
  const UnfoldResult r = unfolding::unfold(p, k, o, {});
  ASSERT_EQ(r.distribution.shapes.size(), 2u);
  for (int s = 0; s < 2; ++s) {
    KMatrix alone = k;
    alone.shapes = {k.shapes[s]};
    const auto expected = unfolding::unfold(one, alone, o, {}).distribution.shapes[0].N_V;
    EXPECT_EQ(r.distribution.shapes[s].shape, s);
    EXPECT_EQ(r.distribution.shapes[s].cls, s);
    for (std::size_t j = 0; j < expected.size(); ++j)
      EXPECT_NEAR(r.distribution.shapes[s].N_V[j], expected[j], 1e-8 + 1e-3 * expected[j]);
  }
  EXPECT_THROW(unfolding::unfold(p, test::spheres<10>(), o, {}), Error);  // two classes, one shape

  // Shapes that name their class say the same.
  o.types = unfolding::Types::Mixed;
  for (int s = 0; s < 2; ++s) {
    k.shapes[s].cls = s;
    k.shapes[s].probability = s == 0 ? 0.9 : 0.1;
  }
  const UnfoldResult named = unfolding::unfold(p, k, o, {});
  ASSERT_EQ(named.distribution.shapes.size(), 2u);
  for (int s = 0; s < 2; ++s) {
    EXPECT_EQ(named.distribution.shapes[s].cls, s);
    EXPECT_EQ(named.distribution.shapes[s].N_V, r.distribution.shapes[s].N_V);
  }
  EXPECT_NEAR(named.distribution.volume_fraction, r.distribution.volume_fraction, 1e-12);
}

// Equation 9: the other classes' shapes say nothing about the largest particle of this one.
TEST(Unfold, ByClassTheLargestSizeFollowsEachClassesOwnMatrix) {
  KMatrix k = test::spheres<10>();
  const auto solid =
      test::run_node("Shape", {}, {{"kind", "tetrahedron"}, {"size", "1"}}).outputs.at("shapes");
  k.shapes.push_back(make_kmatrix(solid.as<Shapes>(), {.orientations = 500}).shapes[0]);
  bool mixed_differs = false;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Observations o = observe(section(5, 10, 0.001, 1e4, seed), Border::Weights, 0, 0);
    const double alone = estimate_d_max(o, test::spheres<10>(), Types::Mixed, 10, 0, {});
    EXPECT_EQ(estimate_d_max(o, k, Types::ByClass, 10, 0, {}), alone);
    mixed_differs = mixed_differs || estimate_d_max(o, k, Types::Mixed, 10, 0, {}) != alone;
  }
  EXPECT_TRUE(mixed_differs);
}

// Sections of tetrahedra rarely come close to the largest one, so that profiles hardly limit the largest
// size.
TEST(Unfold, TheLargestSizeIsTheSmallestThatTheProfilesTellOf) {
  const auto solid =
      test::run_node("Shape", {}, {{"kind", "tetrahedron"}, {"size", "1"}}).outputs.at("shapes");
  const KMatrix k = make_kmatrix(solid.as<Shapes>(), {.classes = 30, .orientations = 500});
  SizeDistribution truth;
  truth.class_edges = {0.5, 1};
  truth.shapes = {{-1, 0, {1}, {1}, {1}}};
  const unfold_study::TrueSizes sizes(truth);
  const unfold_study::ProfileSampler sampler(sizes, k);
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Observations o = observe(sampler.sample(1200, 1, seed, 0, {}), Border::All, 0.05, 0);
    EXPECT_NEAR(estimate_d_max(o, k, Types::Mixed, 21, 0.05, {}), 1, 0.08) << seed;
  }
}

}  // namespace
}  // namespace terrazzo

#include "nodes/shapes/shape_estimate/fit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <atomic>

#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/random_sections.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/shapes/shape/stones.h"
#include "nodes/shapes/shape_estimate/choose.h"
#include "nodes/shapes/shape_estimate/feature_match.h"
#include "nodes/shapes/shape_estimate/least_squares.h"
#include "nodes/shapes/shape_estimate/methods/body_family.h"
#include "nodes/shapes/shape_estimate/methods/swelling.h"
#include "nodes/shapes/shape_estimate/section_sample.h"
#include "nodes/shapes/shape_estimate/self_intersections.h"
#include "runtime/random.h"
#include "tests/nodes/shapes/shape_estimate/synthetic_profiles.h"
#include "tests/support/code_of.h"
#include "tests/support/meshes.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape;

using namespace shape_estimate;
using terrazzo::test::one_shape;
namespace made = shape_estimate::test;

Profiles sections_of(const Shapes& s, std::size_t n) {
  std::vector<made::Contour> contours;
  for (const auto& section : random_sections(s, n, {SectionKind::Random, 3, 0}))
    for (const auto& p : section) contours.push_back(p[0]);
  return made::profiles_of(contours);
}

TEST(ShapeEstimateFit, LeastSquaresFindsTheMinimum) {
  // A curved valley in five dimensions.
  const auto f = [](const Eigen::VectorXd& x) {
    Eigen::VectorXd r(8);
    for (int k = 0; k < 4; ++k) r[k] = 3 * (x[k + 1] - x[k] * x[k]), r[k + 4] = 1 - x[k];
    return r;
  };
  LeastSquaresOptions o;
  o.rounds = 60;
  o.step = 0.01;
  o.ridge = 0;
  const auto best = least_squares(f, Eigen::VectorXd::Zero(5), o);
  EXPECT_LT(best.value, 1e-3);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(best.x[k], 1, 0.05);
}

TEST(ShapeEstimateFit, LeastSquaresStartsWithKnownSlopes) {
  std::atomic<int> calls = 0;
  const auto line = [&](const Eigen::VectorXd& x) {
    ++calls;
    return Eigen::VectorXd(x - Eigen::VectorXd::LinSpaced(6, 1, 2));
  };
  LeastSquaresOptions o;
  o.rounds = 1;
  o.ridge = 0;
  const auto best = least_squares(line, Eigen::VectorXd::Zero(6), o);
  const int differenced = calls.exchange(0);
  const auto again = least_squares(line, best.x, o, {}, best.slope);
  EXPECT_LE(again.value, best.value);
  EXPECT_LE(calls, differenced - 6);  // no difference for each of the six
}

TEST(ShapeEstimateFit, LeastSquaresGoesRoundWhatMakesNothing) {
  const auto f = [](const Eigen::VectorXd& x) {
    if (x[0] > 0.5) return Eigen::VectorXd();
    return Eigen::VectorXd(Eigen::Vector2d(x[0] - 1, x[1] + 2));
  };
  const auto best = least_squares(f, Eigen::VectorXd::Zero(2), {});
  EXPECT_LE(best.x[0], 0.5);
  EXPECT_LT(best.x[1], -0.5);
}

// The means over evenly spread sections satisfy the identities of stereology.
TEST(ShapeEstimateFit, EvenSectionsAreIsotropicUniformRandom) {
  const Shapes s = one_shape(box_mesh({3, 1, 0.5}));
  const auto sample = measured(cut_sections(s.shapes[0].mesh, 2000), {});
  double area = 0;
  for (std::size_t i = 0; i < sample.weight.size(); ++i)
    area += sample.weight[i] * sample.root_area[i] * sample.root_area[i] / total_weight(sample);
  EXPECT_NEAR(area / (s.shapes[0].volume / s.shapes[0].mean_caliper), 1, 0.01);
}

TEST(ShapeEstimateFit, TheDistanceToItselfIsNothing) {
  const Shapes cube = one_shape(box_mesh({1, 1, 1})), slab = one_shape(box_mesh({3, 3, 1}));
  const auto a = measured(cut_sections(cube.shapes[0].mesh, 300), {}),
             b = measured(cut_sections(slab.shapes[0].mesh, 300), {}),
             c = measured(cut_sections(cube.shapes[0].mesh, 300, 300), {});
  const FeatureTarget target(a, false, 1);
  EXPECT_LT(target.distance(a), 0.01);
  EXPECT_LT(target.distance(c), 0.1);
  EXPECT_GT(target.distance(b), 10 * target.distance(c));
  EXPECT_EQ(target.distance({}), 1e6);
}

TEST(ShapeEstimateFit, DropsSmallSectionsAsCandidatesAre) {
  auto s = cut_sections(one_shape(ellipsoid_mesh({1, 1, 1}, 2)).shapes[0].mesh, 500);
  const auto all = s.size();
  drop_small(s, 0.5);
  // For a ball, √area < half the largest means a depth beyond √¾ of the radius; the value that a tenth exceed
  // is almost the largest.
  EXPECT_NEAR(static_cast<double>(s.size()) / static_cast<double>(all), std::sqrt(0.75), 0.02);
}

TEST(ShapeEstimateFit, FamiliesStayClosedWhateverTheNumbers) {
  StoneOptions o;
  o.kind = SolidKind::Clinker;
  o.detail = 2;
  const Mesh start = stone_mesh(o);
  for (int kind = 0; kind < 4; ++kind) {
    const auto family = kind == 0   ? deformed_bodies(start, 1)
                        : kind == 1 ? faceted_bodies(1, 7)
                        : kind == 2 ? faceted_bodies(start, 1)
                                    : modeled_bodies(1, 7);
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      Random r(seed, 4);
      Eigen::VectorXd x(family->dimensions());
      for (Eigen::Index k = 0; k < x.size(); ++k) x[k] = 0.5 * static_cast<double>(seed) / 4 * r.normal();
      const Mesh m = family->body(x);
      if (m.triangles.empty()) continue;
      EXPECT_TRUE(mesh_faults(m).empty());
      EXPECT_EQ(static_cast<int>(m.vertices.size()) - static_cast<int>(m.triangles.size()) / 2, 2);
      EXPECT_GT(mesh_volume(m), 0);
    }
    const Mesh zero = family->body(Eigen::VectorXd::Zero(family->dimensions()));
    EXPECT_EQ(self_intersections(zero), 0);
  }
}

TEST(ShapeEstimateFit, ModeledBodiesDoNotPassThroughThemselves) {
  for (int guess = 0; guess < 24; ++guess) {
    const auto family = modeled_bodies(1, guess);
    const Mesh m = family->body(Eigen::VectorXd::Zero(family->dimensions()));
    EXPECT_EQ(self_intersections(m), 0) << guess;
    EXPECT_NEAR(mesh_volume(m), 4 * std::numbers::pi / 3, 1e-9);
  }
}

// A body with triangles that face its centroid is not star-shaped about it.
TEST(ShapeEstimateFit, ModeledBodiesBendBeyondStars) {
  const auto family = modeled_bodies(1, 0);
  for (const double turn : {0.0, 8.0}) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(family->dimensions());
    x[0] = 4, x[x.size() - 2] = turn;  // elongated, with its long axis bent
    const Mesh m = family->body(x);
    const Vec3 c = mesh_centroid(m);
    const bool hidden = std::any_of(m.triangles.begin(), m.triangles.end(), [&](const Triangle& t) {
      const Vec3 &p = m.vertices[t[0]], &q = m.vertices[t[1]], &s = m.vertices[t[2]];
      return (q - p).cross(s - p).dot(p - c) < 0;
    });
    EXPECT_EQ(hidden, turn > 0);
    EXPECT_EQ(self_intersections(m), 0);
  }
}

// Each random field of a family increases the turning of sections, even the shortest wavelengths: the
// triangles are fine enough.
TEST(ShapeEstimateFit, RoughnessOfAllWavesTurnsSections) {
  const auto family = deformed_bodies(ellipsoid_mesh({1, 1, 1}, 2), 1);
  const auto turning = [&](const Eigen::VectorXd& x) {
    const auto sample = measured(cut_sections(family->body(x), 60), {});
    double sum = 0;
    for (std::size_t i = 0; i < sample.features.size(); ++i)
      sum += sample.weight[i] / total_weight(sample) * sample.features[i][OutlineFeature::TotalCurvature];
    return sum;
  };
  const int fields = 2 + harmonic_count(4);
  const double smooth = turning(Eigen::VectorXd::Zero(family->dimensions()));
  EXPECT_NEAR(smooth, 2 * std::numbers::pi, 0.01);
  for (int k = 0; k < Fields::kCount; ++k) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(family->dimensions());
    x[fields + k] = 2;
    EXPECT_GT(turning(x), smooth + 2) << k;
  }
}

// Outlines that differ by what `change` does with a normal variate, to features and √area.
template <class Change>
FeatureSample sample_of(std::uint64_t seed, Change&& change) {
  FeatureSample a;
  Random r(1, seed);
  for (int i = 0; i < 400; ++i) {
    ProfileFeatures f;
    f.values = {0.06, 7, 0.6, 0.95, 40, 3, 0.9, 0.3, 0, 1, 2, 0.5, 0.7, 0.9};
    double root_area = 1;
    change(r.normal(), f, root_area);
    a.features.push_back(f);
    a.root_area.push_back(root_area);
    a.weight.push_back(1);
  }
  return a;
}

// With particles of one size, it matters which features large sections have, even if
// the distributions are equal.
TEST(ShapeEstimateFit, WhatLargeSectionsAreLikeCounts) {
  const FeatureSample a = sample_of(3, [](double t, ProfileFeatures& f, double& root_area) {
    f.values[1] += t;
    root_area += 0.2 * std::tanh(t);
  });
  FeatureSample turned = a;  // the same areas in reverse
  for (double& area : turned.root_area) area = 2 - area;
  const FeatureTarget one_size(a, true, 1), any(a, false, 1);
  EXPECT_LT(any.distance(turned), 1e-3 + any.distance(a));
  EXPECT_GT(one_size.distance(turned), 0.5 + one_size.distance(a));
}

// A difference of means within each feature's spread counts if it breaks the correlation between features.
TEST(ShapeEstimateFit, WhatBreaksACorrelationCounts) {
  const FeatureSample a = sample_of(2, [](double t, ProfileFeatures& f, double&) {
    f.values[2] += 0.2 * t, f.values[7] += 0.2 * t;  // correlated
  });
  const FeatureTarget target(a, false, 1);
  FeatureSample along = a, across = a;
  for (auto& f : along.features) {
    f.values[2] += 0.06;
    f.values[7] += 0.06;
  }
  for (auto& f : across.features) {
    f.values[2] += 0.06;
    f.values[7] -= 0.06;
  }
  EXPECT_GT(target.distance(across), 1.3 * target.distance(along));
}

TEST(ShapeEstimateFit, ComesNearerThanTheOtherMethods) {
  const Profiles profiles = sections_of(one_shape(box_mesh({2, 1.6, 0.8})), 50);
  const auto candidates = candidates_of(profiles, {.smallest = 0.1});
  FitRequest request;
  request.all = &candidates.outlines;
  for (const auto& hand : choose_profiles(candidates.outlines, "representative", 1, 3, 1)) {
    request.hands.emplace_back();
    for (const int i : hand) request.hands.back().push_back(candidates.outlines[i]);
  }
  request.count = 1;
  request.rounds = 2;
  request.smallest = 0.1;
  request.planes = 40;
  const Fit fit = fit_bodies(request);
  EXPECT_LT(fit.distance, fit.start);
  ASSERT_EQ(fit.bodies.size(), 1u);
  EXPECT_EQ(fit.bodies[0].probability, 1);
  EXPECT_TRUE(mesh_faults(fit.bodies[0].mesh).empty());
  // At the scale of the profiles.
  EXPECT_NEAR(std::cbrt(mesh_volume(fit.bodies[0].mesh) / 2.56), 1, 0.2);
  // The result is the same on one thread.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(fit_bodies(request).bodies[0].mesh.vertices, fit.bodies[0].mesh.vertices);
}

// Mean share of the hull in the largest inscribed quadrilateral: 1 where sections have at most four straight
// sides, 0.637 where they are ellipses.
double quadrilateral_share(const Mesh& mesh) {
  const FeatureSample sample = measured(cut_sections(mesh, 400), {});
  double sum = 0;
  for (std::size_t i = 0; i < sample.features.size(); ++i)
    sum += sample.weight[i] / total_weight(sample) * sample.features[i].values[kOutlineFeatures + 1];
  return sum;
}

TEST(ShapeEstimateFit, ShardsStaySharpAndBallsRound) {
  for (const bool shards : {true, false}) {
    Mesh truth = shards ? platonic_mesh(SolidKind::Tetrahedron) : ellipsoid_mesh({1, 1, 1}, 3);
    for (Vec3& v : truth.vertices) v.x() *= 1.5;
    const Profiles profiles = sections_of(one_shape(truth), 120);
    const auto candidates = candidates_of(profiles, {.smallest = 0.3});
    FitRequest request;
    request.all = &candidates.outlines;
    request.hands.assign(1, {candidates.outlines.begin(), candidates.outlines.begin() + 3});
    request.count = 1;
    request.rounds = 2;
    request.smallest = 0.3;
    request.planes = 100;
    const Fit fit = fit_bodies(request);
    EXPECT_NEAR(quadrilateral_share(fit.bodies[0].mesh), quadrilateral_share(truth), 0.04) << shards;
    EXPECT_EQ(fit.bodies[0].smooth, !shards);
  }
}

TEST(ShapeEstimateFit, TooFewProfilesAreNoDistribution) {
  EXPECT_EQ(terrazzo::test::code_of([] {
              terrazzo::test::run_node(
                  "ShapeEstimate",
                  {{"profiles", Value::of(sections_of(one_shape(box_mesh({2, 1.6, 0.8})), 8))}},
                  {{"method", "fit"}, {"smallest", "0"}});
            }),
            "too-few-profiles");
}

}  // namespace
}  // namespace terrazzo

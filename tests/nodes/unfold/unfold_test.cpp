#include "nodes/unfolding/unfold.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/kmatrix/make_kmatrix.h"
#include "nodes/unfold/limit.h"
#include "nodes/unfold/summary.h"
#include "runtime/random.h"
#include "tests/nodes/unfold/spheres.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace unfold;
using namespace kmatrix;
using namespace unfolding;

// The profiles of a window of `area` mm² through spheres with diameters uniform in [lo, hi] and number
// density `density` per mm³.
Profiles section(double lo, double hi, double density, double area, std::uint64_t seed) {
  Random random(seed);
  Profiles p;
  p.observed_area = area;
  double covered = 0;
  const int n = static_cast<int>(std::lround(density * area * (lo + hi) / 2));
  for (int i = 0; i < n; ++i) {
    // The probability that a plane meets a sphere is proportional to its diameter.
    double d;
    do d = random.uniform(lo, hi);
    while (random.uniform() * hi > d);
    const double h = random.uniform(0, d / 2);
    Profile q;
    q.area = std::numbers::pi * (d * d / 4 - h * h);
    covered += q.area;
    p.profiles.push_back(q);
  }
  p.area_fraction = covered / area;
  return p;
}

double number(const SizeDistribution& d, double lo, double hi) {
  double sum = 0;
  for (const auto& e : d.shapes)
    for (std::size_t i = 0; i < d.classes(); ++i) {
      const double a = d.class_edges[i], b = d.class_edges[i + 1];
      sum += e.N_V[i] * std::max(0.0, std::min(b, hi) - std::max(a, lo)) / (b - a);
    }
  return sum;
}

TEST(Unfold, RecoversUniformSpheres) {
  const Profiles p = section(5, 10, 0.001, 4e6, 3);
  for (const auto method : {unfolding::Method::Em, unfolding::Method::Nnls, unfolding::Method::Inverse}) {
    UnfoldOptions o;
    o.method = method, o.d_max = 10, o.smallest_visible = 0;
    const UnfoldResult r = unfolding::unfold(p, test::spheres<10>(), o, {});
    EXPECT_NEAR(number(r.distribution, 5, 10), 0.001, 0.00004) << static_cast<int>(method);
    EXPECT_NEAR(number(r.distribution, 0, 4), 0, 0.00008) << static_cast<int>(method);
    EXPECT_NEAR(r.distribution.volume_fraction, p.area_fraction, 0.02 * p.area_fraction)
        << static_cast<int>(method);
  }
}

TEST(Unfold, EstimatesTheLargestSize) {
  UnfoldOptions o;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const UnfoldResult r = unfolding::unfold(section(6, 10, 0.001, 60000, seed), test::spheres<10>(), o, {});
    EXPECT_NEAR(r.distribution.d_max, 10, 0.5);
  }
}

TEST(Unfold, FullnessFollowsTheAreaFractionEvenOfAFewProfiles) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Profiles p = section(2, 10, 0.001, 10000, seed);
    const UnfoldResult r = unfolding::unfold(p, test::spheres<10>(), {}, {});
    EXPECT_NEAR(r.distribution.volume_fraction / p.area_fraction, 1, 0.03)
        << seed << ": " << p.profiles.size() << " profiles";
    for (const auto& e : r.distribution.shapes)
      for (const double v : e.N_V) EXPECT_GE(v, 0);
  }
}

TEST(Unfold, IntervalsEncloseTheEstimateAndShrink) {
  double width[2];
  for (int k = 0; k < 2; ++k) {
    UnfoldOptions o;
    o.bootstrap = 60, o.d_max = 10, o.smallest_visible = 0;
    const UnfoldResult r =
        unfolding::unfold(section(5, 10, 0.001, k ? 1.6e6 : 1e5, 5), test::spheres<10>(), o, {});
    const auto& e = r.distribution.shapes[0];
    width[k] = e.high[9] - e.low[9];
    EXPECT_LE(e.low[9], e.N_V[9]);
    EXPECT_GE(e.high[9], e.N_V[9]);
  }
  EXPECT_LT(width[1], 0.5 * width[0]);
}

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

TEST(Unfold, BadInputIsNamed) {
  const auto code = [](const Profiles& p, UnfoldOptions o = {}, const KMatrix* k = nullptr) -> std::string {
    try {
      unfolding::unfold(p, k ? *k : test::spheres<10>(), o, {});
    } catch (const Error& e) {
      return e.diagnostic().code;
    }
    return "none";
  };
  const Profiles good = section(5, 10, 0.001, 1e5, 3);
  EXPECT_EQ(code(good), "none");
  EXPECT_EQ(code(Profiles()), "no-profiles");
  Profiles p = good;
  p.profiles[3].area = std::nan("");
  EXPECT_EQ(code(p), "bad-profiles");
  p = good;
  p.profiles[3].area = 0;
  EXPECT_EQ(code(p), "bad-profiles");
  p = good;
  for (auto& q : p.profiles) q.weight = 0;
  EXPECT_EQ(code(p), "no-profiles");
  p = good;
  p.profiles.resize(1);
  EXPECT_EQ(code(p), "too-few-profiles");
  EXPECT_EQ(code(good, {.smallest_visible = 100}), "no-profiles");
  EXPECT_EQ(code(good, {.d_max = 1}), "too-small");
  KMatrix empty = test::spheres<10>();
  empty.shapes.clear();
  EXPECT_EQ(code(good, {}, &empty), "bad-kmatrix");
  // A body whose sections are almost invisible: its K matrix has empty columns or is singular.
  KMatrix blind = test::spheres<10>();
  std::fill(blind.shapes[0].cdf.begin(), blind.shapes[0].cdf.end(), 1.0);
  for (const auto method : {unfolding::Method::Em, unfolding::Method::Nnls, unfolding::Method::Inverse})
    EXPECT_EQ(code(good, {.method = method, .smallest_visible = 2}, &blind), "bad-kmatrix")
        << static_cast<int>(method);
  EXPECT_EQ(code(good, {.method = unfolding::Method::Inverse, .smallest_visible = 0, .d_max = 12}, &blind),
            "singular");
  // The number of classes of the K matrix does not matter: the result equals that of a matrix
  // with the requested classes.
  const auto solved = [&](int classes) {
    const auto ball = test::run_node("Shape", {}, {{"kind", "sphere"}, {"size", "1"}}).outputs.at("shapes");
    const KMatrix k =
        make_kmatrix(ball.as<Shapes>(), {.method = kmatrix::Method::Analytic, .classes = classes});
    return unfolding::unfold(good, k, {.method = unfolding::Method::Nnls, .classes = 8, .d_max = 12}, {})
        .distribution.shapes[0]
        .N_V;
  };
  EXPECT_EQ(solved(5), solved(8));
  Profiles equal = good;
  for (auto& q : equal.profiles) q.area = 10;
  EXPECT_EQ(code(equal), "none");
}

TEST(Unfold, WhatCannotFillAVolumeIsRefused) {
  // The inverse for angular bodies amplifies counting errors by orders of magnitude.
  const auto solid =
      test::run_node("Shape", {}, {{"kind", "octahedron"}, {"size", "1"}}).outputs.at("shapes");
  const KMatrix k = make_kmatrix(solid.as<Shapes>(), {.classes = 14, .orientations = 500});
  UnfoldOptions o;
  o.method = unfolding::Method::Inverse, o.d_max = 12, o.smallest_visible = 0;
  try {
    unfolding::unfold(section(2, 10, 0.001, 3e4, 4), k, o, {});
    FAIL() << "a density of particles that do not fit";
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "unstable") << e.what();
    EXPECT_EQ(e.diagnostic().parameter, "classes");
  }
  for (const auto method : {unfolding::Method::Nnls, unfolding::Method::Em}) {
    o.method = method;
    const UnfoldResult r = unfolding::unfold(section(2, 10, 0.001, 3e4, 4), k, o, {});
    EXPECT_LT(r.distribution.volume_fraction, 1);
  }
}

TEST(Unfold, MissingFinesAreNotTakenForNone) {
  // A photograph that shows nothing below 3 mm, of particles between 1 and 10 mm.
  Profiles p = section(1, 10, 0.001, 1e6, 8);
  std::erase_if(p.profiles, [](const Profile& q) { return q.area < std::numbers::pi / 4 * 9; });
  UnfoldOptions o;
  o.d_max = 10, o.smallest_visible = 3;
  const UnfoldResult blind = unfolding::unfold(p, test::spheres<10>(), o, {});
  EXPECT_NEAR(number(blind.distribution, 4, 10) / (0.001 * 6 / 9), 1, 0.1);
  EXPECT_EQ(number(blind.distribution, 0, 3), 0);
  EXPECT_EQ(blind.distribution.class_edges[static_cast<std::size_t>(blind.model.first)], 3);
}

TEST(Unfold, WithoutAnAreaDensitiesAreRelative) {
  Profiles p = section(5, 10, 0.001, 1e5, 3);
  const UnfoldResult known = unfolding::unfold(p, test::spheres<10>(), {.d_max = 10, .bootstrap = 10}, {});
  p.observed_area = 0, p.area_fraction = 0;
  for (const auto method : {unfolding::Method::Em, unfolding::Method::Nnls, unfolding::Method::Inverse}) {
    const UnfoldResult r = unfolding::unfold(p, test::spheres<10>(), {.method = method, .d_max = 10}, {});
    EXPECT_TRUE(r.observations.relative);
    double sum = 0;
    for (const double v : r.distribution.shapes[0].N_V) sum += v;
    EXPECT_NEAR(sum, 1, 1e-12) << static_cast<int>(method);
    EXPECT_EQ(r.distribution.volume_fraction, 0) << static_cast<int>(method);
  }
  const auto& absolute = known.distribution.shapes[0].N_V;
  const auto relative =
      unfolding::unfold(p, test::spheres<10>(), {.d_max = 10}, {}).distribution.shapes[0].N_V;
  double sum = 0;
  for (const double v : absolute) sum += v;
  for (std::size_t j = 0; j < absolute.size(); ++j) EXPECT_NEAR(relative[j], absolute[j] / sum, 0.01);
  const auto warned =
      test::run_node("Unfold", {{"profiles", Value::of(p)}, {"kmatrix", Value::of(test::spheres<10>())}},
                     {{"bootstrap", "0"}});
  EXPECT_EQ(warned.warnings.size(), 1u);
}

TEST(Unfold, FewProfilesGetFewerClassesAndAWarning) {
  Profiles p = section(5, 10, 0.001, 1e5, 3);
  p.profiles.resize(40);
  p.area_fraction = 0, p.observed_area = 1e4;
  const auto classes_and_warnings = [&](const std::string& classes) {
    const auto run =
        test::run_node("Unfold", {{"profiles", Value::of(p)}, {"kmatrix", Value::of(test::spheres<10>())}},
                       {{"bootstrap", "0"}, {"classes", classes}, {"method", "nnls"}});
    return std::pair(run.output<SizeDistribution>("distribution").classes(), run.warnings.size());
  };
  EXPECT_EQ(classes_and_warnings("auto"), std::pair(std::size_t{6}, std::size_t{1}));
  EXPECT_EQ(classes_and_warnings("10"), std::pair(std::size_t{10}, std::size_t{0}));
  EXPECT_EQ(classes_and_warnings("60").second, 1u);  // fewer profiles than classes
}

// Many particles of half a millimeter to one beside few of 6 to 14 mm.
Profiles small_beside_large() {
  Profiles p = section(0.5, 1, 0.03, 1e4, 4);
  const Profiles large = section(6, 14, 0.0003, 1e4, 5);
  p.profiles.insert(p.profiles.end(), large.profiles.begin(), large.profiles.end());
  p.area_fraction += large.area_fraction;
  return p;
}

TEST(Unfold, TheSmallestClassIsDividedWhereSizesDifferMuch) {
  // In one class of 0.4 to 2 mm, whose sizes count as uniform, the same number of small particles would show
  // far more profiles.
  Profiles p = small_beside_large();
  std::erase_if(p.profiles, [](const Profile& q) { return q.area < std::numbers::pi / 4 * 0.16; });
  const double observed = static_cast<double>(p.profiles.size()) / p.observed_area;
  // The profiles of spheres of these sizes, relative to those observed.
  const auto shown = [&](int classes) {
    UnfoldOptions o;
    o.smallest_visible = 0.4, o.classes = classes;
    const UnfoldResult r = unfolding::unfold(p, test::spheres<8>(), o, {});
    EXPECT_LT(r.model.edges.back(), 16);
    if (classes == 0) {
      EXPECT_EQ(r.model.equal, 8);
      EXPECT_GT(r.model.classes(), 8);
      for (std::size_t i = 0; r.model.profile_edges[i] < 1; ++i)
        EXPECT_LE(r.model.profile_edges[i + 1], 2 * r.model.profile_edges[i] * (1 + 1e-12));
    } else {
      EXPECT_EQ(r.model.classes(), classes);
    }
    double sum = 0;
    for (int j = 0; j < r.model.visible(); ++j)
      sum += r.fits[0].density[j] * r.model.matrix.col(j).sum() / observed;
    return sum;
  };
  EXPECT_NEAR(shown(0), 1, 0.15);
  EXPECT_GT(shown(8), 1.5);
}

TEST(Unfold, TheSmallestClassStaysWholeWhereItHoldsFewProfiles) {
  Profiles p = section(6, 14, 0.0005, 1e4, 6);
  p.profiles[0].area = 0.01;
  UnfoldOptions o;
  const UnfoldResult r = unfolding::unfold(p, test::spheres<8>(), o, {});
  EXPECT_LT(r.model.profile_edges[0] * 2, r.model.profile_edges[1]);
  const auto in_first = std::ranges::count_if(p.profiles, [&](const Profile& q) {
    return std::sqrt(4 * q.area / std::numbers::pi) <= r.model.profile_edges[1];
  });
  EXPECT_LT(r.model.equal * in_first, static_cast<std::ptrdiff_t>(p.profiles.size()));
  EXPECT_EQ(r.model.classes(), r.model.equal);
}

TEST(Unfold, EqualProfilesGiveSizesNearTheirs) {
  Profiles p;
  p.observed_area = 1e5;
  p.profiles.resize(300);
  for (auto& q : p.profiles) q.area = std::numbers::pi / 4 * 36;
  p.area_fraction = 300 * p.profiles[0].area / p.observed_area;
  const UnfoldResult r = unfolding::unfold(p, test::spheres<10>(), {.smallest_visible = 0, .d_max = 10}, {});
  EXPECT_GT(number(r.distribution, 5, 8), 0.95 * number(r.distribution, 0, 10));
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
  for (Profile q : one.profiles) q.cls = 1, p.profiles.push_back(q);
  p.classes = 2, p.area_fraction = 2 * one.area_fraction;
  UnfoldOptions o;
  o.d_max = 10, o.smallest_visible = 0, o.types = unfolding::Types::ByClass;
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
  for (int s = 0; s < 2; ++s) k.shapes[s].cls = s, k.shapes[s].probability = s == 0 ? 0.9 : 0.1;
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
      test::run_node("Shape", {}, {{"kind", "octahedron"}, {"size", "1"}}).outputs.at("shapes");
  k.shapes.push_back(make_kmatrix(solid.as<Shapes>(), {.orientations = 500}).shapes[0]);
  bool mixed_differs = false;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Observations o = observe(section(5, 10, 0.001, 1e5, seed), Border::Weights, 0, 0);
    const double alone = estimate_d_max(o, test::spheres<10>(), Types::Mixed, 10, 0, {});
    EXPECT_EQ(estimate_d_max(o, k, Types::ByClass, 10, 0, {}), alone);
    mixed_differs = mixed_differs || estimate_d_max(o, k, Types::Mixed, 10, 0, {}) != alone;
  }
  EXPECT_TRUE(mixed_differs);
}

TEST(Unfold, BorderWeightsCountWhatTheWindowCuts) {
  // Discs of equal spheres in a window so small that its border cuts a third of them.
  Random random(21);
  const double side = 40, d = 8, n_v = 0.002;
  Profiles p;
  p.window = {side, side};
  const int windows = 400;
  p.sections = windows, p.observed_area = windows * side * side;
  double covered = 0;
  for (int w = 0; w < windows; ++w) {
    const double reach = side + d;
    const auto n = static_cast<int>(n_v * d * reach * reach + random.uniform());
    for (int i = 0; i < n; ++i) {
      const double h = random.uniform(0, d / 2), r = std::sqrt(d * d / 4 - h * h);
      const double x = random.uniform(-d / 2, side + d / 2), y = random.uniform(-d / 2, side + d / 2);
      if (x + r < 0 || y + r < 0 || x - r > side || y - r > side) continue;
      Profile q;
      q.section = w, q.area = std::numbers::pi * r * r;
      q.touches_border = x < r || y < r || x > side - r || y > side - r;
      q.weight = q.touches_border ? 0 : side * side / ((side - 2 * r) * (side - 2 * r));
      if (!q.touches_border) covered += q.weight * q.area;
      p.profiles.push_back(q);
    }
  }
  p.area_fraction = covered / p.observed_area;
  const auto n_a = [&](Border border) {
    UnfoldOptions o;
    o.border = border, o.d_max = d, o.smallest_visible = 0;
    return unfolding::unfold(p, test::spheres<10>(), o, {}).fits[0].observed.sum() / (n_v * d);
  };
  EXPECT_NEAR(n_a(Border::Weights), 1, 0.02);
  EXPECT_GT(n_a(Border::All), 1.15);
  EXPECT_LT(n_a(Border::Inside), 0.85);
}

// Grains that fill space: sampling noise must not make them overfull.
TEST(Unfold, ParticlesMayFillTheVolume) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Profiles p = section(5, 10, 0.001, 1e5, seed);
    double covered = 0;
    for (const Profile& q : p.profiles) covered += q.area;
    p.observed_area = covered, p.area_fraction = 1;
    const UnfoldResult r = unfolding::unfold(p, test::spheres<10>(), {.bootstrap = 10}, {});
    EXPECT_LE(r.distribution.volume_fraction, 1);
    EXPECT_GT(r.distribution.volume_fraction, 0.97);
    double sum = 0;
    for (int j = 0; j < r.model.visible(); ++j) sum += r.model.volume[j] * r.fits[0].density[j];
    EXPECT_NEAR(sum, r.distribution.volume_fraction, 1e-9);
  }
}

// Where small profiles are missing, the fit without the smallest class finds more of the larger particles'
// neighbors in size; where none are missing, it finds the same.
TEST(Unfold, LimitSensitivityShowsMissingSmallProfiles) {
  const auto effect = [](const Profiles& p) {
    UnfoldOptions o;
    o.d_max = 10, o.smallest_visible = 1;
    const auto s =
        limit_sensitivity(p, test::spheres<10>(), o, unfolding::unfold(p, test::spheres<10>(), o, {}), {});
    EXPECT_TRUE(s.has_value());
    return s.value_or(LimitSensitivity{});
  };
  const Profiles all = section(1, 10, 0.001, 4e5, 3);
  const LimitSensitivity good = effect(all);
  EXPECT_NEAR(good.change, 0, 0.03);
  EXPECT_NEAR(good.share, 1.0 / 9, 0.05);
  Profiles few = all;  // of the profiles below 2 mm, one in ten is seen
  std::size_t k = 0;
  std::erase_if(few.profiles, [&](const Profile& q) { return q.area < std::numbers::pi && k++ % 10 != 0; });
  EXPECT_GT(effect(few).change, good.change + 0.02);
  EXPECT_FALSE(limit_sensitivity(
                   all, test::spheres<10>(), {.classes = 2, .smallest_visible = 1},
                   unfolding::unfold(all, test::spheres<10>(), {.classes = 2, .smallest_visible = 1}, {}), {})
                   .has_value());
}

TEST(UnfoldSummary, MeansAndQuantilesOfKnownSizes) {
  SizeDistribution d;
  d.class_edges = {1, 2, 4};
  d.shapes.resize(2);
  d.shapes[0].N_V = {2, 0}, d.shapes[1].N_V = {1, 1};
  const SizeSummary s = summarize(d);
  EXPECT_NEAR(s.N_V, 4, 1e-12);
  EXPECT_NEAR(s.mean, (3 * 1.5 + 3) / 4, 1e-12);
  EXPECT_NEAR(s.median, 1 + 2.0 / 3, 1e-12);
  // Volumes: 3 · (2⁴ − 1)/4 and 1 · (4⁴ − 2⁴)/8.
  EXPECT_NEAR(s.volume_share[0], 11.25 / (11.25 + 30), 1e-12);
  EXPECT_EQ(s.volume_passing[1], 1);
  EXPECT_NEAR(std::pow(s.d50, 4), 16 + 240 * (0.5 * 41.25 - 11.25) / 30, 1e-9);
  EXPECT_LT(s.d10, s.d50);
  EXPECT_LT(s.d50, s.d90);
  // A fine histogram of a lognormal reproduces its parameters.
  d.class_edges.clear(), d.shapes.resize(1), d.shapes[0].N_V.clear();
  for (int i = 0; i <= 2000; ++i) d.class_edges.push_back(i * 0.01);
  for (int i = 0; i < 2000; ++i) {
    const double x = (i + 0.5) * 0.01;
    d.shapes[0].N_V.push_back(std::exp(-0.5 * std::pow(std::log(x / 3) / 0.4, 2)) / x);
  }
  const SizeSummary l = summarize(d);
  EXPECT_NEAR(l.geometric_mean, 3, 0.005);
  EXPECT_NEAR(std::log(l.geometric_sd), 0.4, 0.002);
  EXPECT_NEAR(l.d50, 3 * std::exp(3 * 0.16), 0.03);  // Hatch and Choate 1929
  EXPECT_EQ(summarize({}).N_V, 0);
}

TEST(Unfold, SameBitsOnAnyNumberOfThreads) {
  const Value profiles = Value::of(section(3, 10, 0.001, 3e5, 9)), k = Value::of(test::spheres<10>());
  const auto at = [&](int threads) {
    const auto d = test::run_node("Unfold", {{"profiles", profiles}, {"kmatrix", k}}, {}, {}, threads)
                       .output<SizeDistribution>("distribution");
    return std::pair(d.shapes[0].N_V, d.shapes[0].high);
  };
  EXPECT_EQ(at(1), at(3));
}

}  // namespace
}  // namespace terrazzo

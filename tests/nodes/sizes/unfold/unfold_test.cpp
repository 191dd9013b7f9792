// Densities and sizes of known particles.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/sizes/unfolding/unfold.h"
#include "runtime/random.h"
#include "tests/nodes/sizes/unfold/spheres.h"
#include "tests/nodes/sizes/unfold/spheres_section.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace unfolding;
using test::number;
using test::section;

TEST(Unfold, RecoversUniformSpheres) {
  const Profiles p = section(5, 10, 0.001, 4e6, 3);
  for (const auto method : {unfolding::Method::Em, unfolding::Method::Nnls, unfolding::Method::Inverse}) {
    UnfoldOptions o;
    o.method = method;
    o.d_max = 10;
    o.smallest_visible = 0;
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
    o.bootstrap = 60;
    o.d_max = 10;
    o.smallest_visible = 0;
    const UnfoldResult r =
        unfolding::unfold(section(5, 10, 0.001, k ? 1.6e6 : 1e5, 5), test::spheres<10>(), o, {});
    const auto& e = r.distribution.shapes[0];
    width[k] = e.high[9] - e.low[9];
    EXPECT_LE(e.low[9], e.N_V[9]);
    EXPECT_GE(e.high[9], e.N_V[9]);
  }
  EXPECT_LT(width[1], 0.5 * width[0]);
}

TEST(Unfold, WithoutAnAreaDensitiesAreRelative) {
  Profiles p = section(5, 10, 0.001, 1e5, 3);
  const UnfoldResult known = unfolding::unfold(p, test::spheres<10>(), {.d_max = 10, .bootstrap = 10}, {});
  p.observed_area = 0;
  p.area_fraction = 0;
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

TEST(Unfold, EqualProfilesGiveSizesNearTheirs) {
  Profiles p;
  p.observed_area = 1e5;
  p.profiles.resize(300);
  for (auto& q : p.profiles) q.area = std::numbers::pi / 4 * 36;
  p.area_fraction = 300 * p.profiles[0].area / p.observed_area;
  const UnfoldResult r = unfolding::unfold(p, test::spheres<10>(), {.smallest_visible = 0, .d_max = 10}, {});
  EXPECT_GT(number(r.distribution, 5, 8), 0.95 * number(r.distribution, 0, 10));
}

TEST(Unfold, BorderWeightsCountWhatTheWindowCuts) {
  // Discs of equal spheres in a window so small that its border cuts a third of them.
  Random random(21);
  const double side = 40, d = 8, n_v = 0.002;
  Profiles p;
  p.window = {side, side};
  const int windows = 400;
  p.sections = windows;
  p.observed_area = windows * side * side;
  double covered = 0;
  for (int w = 0; w < windows; ++w) {
    const double reach = side + d;
    const auto n = static_cast<int>(n_v * d * reach * reach + random.uniform());
    for (int i = 0; i < n; ++i) {
      const double h = random.uniform(0, d / 2), r = std::sqrt(d * d / 4 - h * h);
      const double x = random.uniform(-d / 2, side + d / 2), y = random.uniform(-d / 2, side + d / 2);
      if (x + r < 0 || y + r < 0 || x - r > side || y - r > side) continue;
      Profile q;
      q.section = w;
      q.area = std::numbers::pi * r * r;
      q.touches_border = x < r || y < r || x > side - r || y > side - r;
      q.weight = q.touches_border ? 0 : side * side / ((side - 2 * r) * (side - 2 * r));
      if (!q.touches_border) covered += q.weight * q.area;
      p.profiles.push_back(q);
    }
  }
  p.area_fraction = covered / p.observed_area;
  const auto n_a = [&](Border border) {
    UnfoldOptions o;
    o.border = border;
    o.d_max = d;
    o.smallest_visible = 0;
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
    p.observed_area = covered;
    p.area_fraction = 1;
    const UnfoldResult r = unfolding::unfold(p, test::spheres<10>(), {.bootstrap = 10}, {});
    EXPECT_LE(r.distribution.volume_fraction, 1);
    EXPECT_GT(r.distribution.volume_fraction, 0.97);
    double sum = 0;
    for (int j = 0; j < r.model.visible(); ++j) sum += r.model.volume[j] * r.fits[0].density[j];
    EXPECT_NEAR(sum, r.distribution.volume_fraction, 1e-9);
  }
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

// Sizes from the silhouettes of a surface.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/common/stereology/silhouette.h"
#include "nodes/sizes/unfolding/hiding.h"
#include "nodes/sizes/unfolding/model.h"
#include "nodes/sizes/unfolding/unfold.h"
#include "runtime/random.h"
#include "tests/nodes/sizes/unfold/spheres.h"

namespace terrazzo {
namespace {
using namespace unfolding;
using std::numbers::pi;

Loop ellipse(double a, double b, int points = 120) {
  Loop out;
  for (int i = 0; i < points; ++i)
    out.emplace_back(a * std::cos(2 * pi * i / points), b * std::sin(2 * pi * i / points));
  return out;
}

// A disc of radius 1 without what a disc of radius `r` at distance `d` to its right covers.
Loop bitten(double r, double d, int points = 720) {
  Loop out;
  for (int i = 0; i < points; ++i) {
    const double t = 2 * pi * i / points;
    Vec2 p(std::cos(t), std::sin(t));
    const Vec2 q = p - Vec2(d, 0);
    if (q.norm() < r) {
      // On the ray from the left end, the near side of the other disc.
      const Vec2 ray = (p - Vec2(-1, 0)).normalized(), to = Vec2(d + 1, 0);
      const double along = to.dot(ray);
      p = Vec2(-1, 0) + (along - std::sqrt(r * r - to.squaredNorm() + along * along)) * ray;
    }
    out.push_back(p);
  }
  return out;
}

TEST(Silhouette, CompletesBittenDiscs) {
  EXPECT_NEAR(whole_silhouette(ellipse(1, 1)) / pi, 1, 0.005);
  EXPECT_NEAR(whole_silhouette(ellipse(2, 0.8)) / (1.6 * pi), 1, 0.005);
  EXPECT_NEAR(whole_silhouette(bitten(1, 1.2)) / pi, 1, 0.04);
  EXPECT_NEAR(whole_silhouette(bitten(1, 0.9)) / pi, 1, 0.08);
  EXPECT_NEAR(whole_silhouette(bitten(3, 3.2)) / pi, 1, 0.08);
  // Never below the hull, here that of a square, and nothing for what is no outline.
  EXPECT_GE(whole_silhouette({{0, 0}, {1, 0}, {1, 1}, {0, 1}}), 1 - 1e-6);
  EXPECT_EQ(whole_silhouette({{0, 0}, {1, 0}}), 0);
}

// A shape that was traced from a stone is that of particles of about its size, and those beyond all stones
// have the nearest ones.
TEST(SizeTrend, TracedShapesBelongToTheirSize) {
  KMatrix k;
  k.shapes.resize(3);
  for (int s = 0; s < 3; ++s) {
    k.shapes[s].probability = 1.0 / 3;
    k.shapes[s].trend = {0, std::pow(2.0, s), 0.3};
  }
  for (int s = 0; s < 3; ++s) {
    const auto shares = shape_shares(k, std::pow(2.0, s));
    EXPECT_NEAR(shares[0] + shares[1] + shares[2], 1, 1e-12);
    EXPECT_GT(shares[s], 0.98);
  }
  EXPECT_NEAR(shape_shares(k, std::sqrt(2.0))[0], shape_shares(k, std::sqrt(2.0))[1], 1e-12);
  EXPECT_GT(shape_shares(k, 100)[2], 0.5);
  EXPECT_GT(shape_shares(k, 0.01)[0], 0.5);
}

TEST(Hiding, MatrixCountsWhatIsSeen) {
  const std::vector<double> edges{0.5, 1, 2, 3, 4};
  for (const Bed kind : {Bed::Soil, Bed::Loose}) {
    const Hiding h(kind, 0.6);
    const Eigen::MatrixXd m = h.matrix(edges, edges);
    // All classes together: everything that looks larger than 0.5.
    for (int j = 0; j < m.cols(); ++j) {
      double all = 0;
      for (int k = 0; k < 1000; ++k)
        all += h.above(edges[j] + (edges[j + 1] - edges[j]) * (k + 0.5) / 1000, 0.5) / 1000;
      EXPECT_NEAR(m.col(j).sum(), all, 0.01 * all);
    }
  }
}

TEST(Hiding, SoilShowsWholeStonesOfOneLayer) {
  const Hiding h(Bed::Soil, 0.6);
  EXPECT_DOUBLE_EQ(h.above(4, 3), 4 * 0.6);
  EXPECT_EQ(h.above(4, 4.5), 0);
}

TEST(Hiding, LooseStonesLeanAndHideEachOther) {
  const Hiding balls(Bed::Loose, 1), flat(Bed::Loose, 0.5);
  // Half way between the height of a flat spheroid and its mean caliper diameter, (0.5 + (π/3) / √0.75) / 2.
  EXPECT_NEAR(flat.above(4, 0.1) / balls.above(4, 0.1), (0.5 + (0.5 + pi / 3 / std::sqrt(0.75)) / 2) / 2,
              0.002);
  // Parts look smaller, and so do stones that lean.
  EXPECT_LT(balls.above(4, 3.6), 0.4 * balls.above(4, 0.1));
  EXPECT_LT(flat.above(4, 3.6) / flat.above(4, 0.1), 0.8 * balls.above(4, 3.6) / balls.above(4, 0.1));
  EXPECT_EQ(balls.above(4, 4.5), 0);
}

// Soil, so that no fraction is assumed, or shadows between loose stones.
Profiles nothing_on(double area, Bed kind) {
  Profiles p;
  p.view = View::Surface;
  p.observed_area = area;
  p.area_fraction = 0.7;
  p.binder_color.setConstant(kind == Bed::Soil ? 0.3F : 0.05F);
  return p;
}

Profile silhouette(double size) {
  Profile q;
  q.area = q.whole = pi / 4 * size * size;
  q.color.setConstant(0.3F);
  return q;
}

// Draws what a bed of balls of two sizes shows, by the law of hiding.
Profiles bed(double side, std::uint64_t seed, double large, double small, Bed kind = Bed::Soil) {
  const std::vector<double> sizes{3, 6}, density{small, large};
  constexpr double kSmallest = 0.6;
  const Hiding h(kind, 1);
  Random random(seed);
  Profiles p = nothing_on(side * side, kind);
  for (int k = 0; k < 2; ++k) {
    const double all = h.above(sizes[k], kSmallest);
    const double mean = density[k] * all * side * side;
    const auto n = static_cast<int>(std::lround(mean + std::sqrt(mean) * random.normal()));
    for (int i = 0; i < n; ++i) {
      // Inverts the falling number of silhouettes above a size.
      double low = kSmallest, high = 1.1 * sizes[k];
      const double wanted = random.uniform() * all;
      for (int step = 0; step < 40; ++step) {
        const double middle = (low + high) / 2;
        (h.above(sizes[k], middle) > wanted ? low : high) = middle;
      }
      p.profiles.push_back(silhouette(low));
    }
  }
  return p;
}

TEST(UnfoldSurface, RecoversABedOfTwoSizes) {
  // Loose balls of these densities fill kLooseFraction.
  const double large = 0.0024, small = (kLooseFraction / (pi / 6) - large * 216) / 27;
  for (const Bed kind : {Bed::Soil, Bed::Loose}) {
    double sum_large = 0, sum_small = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const UnfoldResult r =
          unfolding::unfold(bed(100, seed, large, small, kind), test::spheres<30>(), {}, {});
      for (int j = 0; j < r.model.visible(); ++j) {
        const double from = r.model.profile_edges[j];
        (from < 4.2 ? sum_small : sum_large) += r.fits[0].density[j] / 4;
      }
    }
    EXPECT_NEAR(sum_large / large, 1, 0.12);
    EXPECT_NEAR(sum_small / small, 1, 0.12);
  }
}

// Taken for cuts, the same outlines give other numbers; and the cover of a surface is no volume fraction.
TEST(UnfoldSurface, SilhouettesAreNoCuts) {
  double surface = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    surface += unfolding::unfold(bed(100, seed, 0.0024, 0.019), test::spheres<30>(), {}, {})
                   .distribution.volume_fraction /
               4;
  EXPECT_NEAR(surface, 0.0024 * pi / 6 * 216 + 0.019 * pi / 6 * 27, 0.04);
  Profiles p = bed(100, 9, 0.0024, 0.019);
  p.view = View::Section;
  p.area_fraction = 0.9;
  for (Profile& q : p.profiles) q.whole = 0;
  EXPECT_NEAR(unfolding::unfold(p, test::spheres<30>(), {}, {}).distribution.volume_fraction, 0.9, 0.02);
}

Profiles silhouettes(int small, int large, Bed kind) {
  Profiles p = nothing_on(1600, kind);
  Random random(7);
  for (int i = 0; i < small + large; ++i)
    p.profiles.push_back(silhouette((i < small ? 1 : 4) * random.uniform(0.99, 1.01)));
  return p;
}

// Stones of one size are one layer, N_A / D, and none are left out as parts.
TEST(UnfoldSurface, NearlyEqualStonesAreCounted) {
  const UnfoldResult r = unfolding::unfold(silhouettes(0, 100, Bed::Soil), test::spheres<30>(), {}, {});
  EXPECT_NEAR(r.fits[0].density.sum() / (100 / 1600.0 / 4), 1, 0.15);
  const auto few = unfolding::unfold(silhouettes(300, 2, Bed::Loose), test::spheres<30>(), {}, {});
  EXPECT_GE(few.observations.used, 151U);
}

TEST(UnfoldSurface, LooseStonesFillAKnownShare) {
  Profiles p = bed(100, 3, 0.0012, 0.0095);  // half as many as fit
  EXPECT_FALSE(shows_loose_stones(p));
  p.binder_color.setConstant(0.05F);  // shadows
  EXPECT_TRUE(shows_loose_stones(p));
  Profiles covered = bed(100, 3, 0.0012, 0.0095);
  covered.area_fraction = 0.85;  // stones in soil do not lie on each other
  EXPECT_TRUE(shows_loose_stones(covered));
  const double free = 0.0012 * pi / 6 * 216 + 0.0095 * pi / 6 * 27;
  const double found = unfolding::unfold(p, test::spheres<30>(), {}, {}).distribution.volume_fraction;
  EXPECT_GT(found, 1.15 * free);
  EXPECT_LT(found, kLooseFraction * 1.05);
}

TEST(UnfoldSurface, FlatStonesAreMoreInALayer) {
  // Shapes of half the height: twice as many stones per volume show the same silhouettes.
  const Profiles p = bed(100, 5, 0.0024, 0.019);
  KMatrix flat = test::spheres<30>();
  flat.shapes[0].volume /= 2;
  const auto density = [&](const KMatrix& k) {
    const UnfoldResult r = unfolding::unfold(p, k, {}, {});
    return r.fits[0].density.sum();
  };
  EXPECT_NEAR(density(flat) / density(test::spheres<30>()), 2, 0.02);
}

TEST(UnfoldSurface, IntervalsContainTheErrorOfTheLaw) {
  const Profiles p = bed(300, 5, 0.0024, 0.019);  // so many that counting errors are small
  const auto r = unfolding::unfold(p, test::spheres<30>(), {.bootstrap = 20}, {});
  const auto& e = r.distribution.shapes[0];
  const std::size_t k = std::max_element(e.N_V.begin(), e.N_V.end()) - e.N_V.begin();
  EXPECT_LT(e.low[k], (1 - 1.5 * kHidingError) * e.N_V[k]);
  EXPECT_GT(e.high[k], (1 + 1.5 * kHidingError) * e.N_V[k]);
}

}  // namespace
}  // namespace terrazzo

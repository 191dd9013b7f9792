// Correlations, surfaces and representative volumes against closed forms.
#include "nodes/packing/measure3d/correlation.h"

#include <gtest/gtest.h>

#include "nodes/packing/measure3d/subvolumes.h"
#include "nodes/packing/measure3d/surfaces.h"
#include "tests/nodes/packing/measure3d/blocks.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace measure3d;

Raster complement(Raster r) {
  for (auto& v : r.in) v = !v;
  r.inside = r.count() - r.inside;
  return r;
}

// Against the definition, for boxes whose sizes are a prime, odd and even, with voxels of three lengths.
TEST(Measure3DCorrelation, IsTheShareOfSegments) {
  const Vec3i n(11, 9, 8);
  const Vec3 spacing(1, 1.5, 2);
  for (const bool periodic : {true, false}) {
    const Raster raster = test::raster_of(n, spacing, periodic, [](int x, int y, int z) {
      return Random(4, 1, static_cast<std::uint64_t>((z * 9 + y) * 11 + x)).uniform() < 0.7 ? 0 : -1;
    });
    const Correlation c = correlate(raster, test::kPlenty, {});
    EXPECT_EQ(c.step, 1);
    ASSERT_EQ(c.mean.size(), 6u);  // half of the shortest edge, 11 mm
    const auto in = [&](Vec3i v) {
      for (int a = 0; a < 3; ++a) v[a] = wrap_index(v[a], n[a]);
      return raster.in[raster.index(v.x(), v.y(), v.z())] != 0;
    };
    const auto shares = [&](const Vec3i& d) {  // of segments by d: both ends, and along an axis the whole one
      double both = 0, whole = 0, count = 0;
      for (int z = 0; z < n.z(); ++z)
        for (int y = 0; y < n.y(); ++y)
          for (int x = 0; x < n.x(); ++x) {
            const Vec3i from(x, y, z), to = from + d;
            if (!periodic && ((to.array() < 0).any() || (to.array() >= n.array()).any())) continue;
            ++count, both += in(from) && in(to);
            bool all = true;
            const int steps = d.cwiseAbs().maxCoeff();
            for (int k = 0; k <= steps; ++k)
              all = all && in(from + (steps ? Vec3i(d / steps * k) : Vec3i(0, 0, 0)));
            whole += all;
          }
      return std::pair(both / count, whole / count);
    };
    const int longest[] = {5, 4, 3};  // voxels within reach
    for (int a = 0; a < 3; ++a)
      for (int k = 0; k <= longest[a] - (periodic ? 0 : 0); ++k) {
        const double r = k * spacing[a];
        if (r > 5 || r != std::floor(r)) continue;
        const auto [both, whole] = shares(k * Vec3i::Unit(a));
        EXPECT_NEAR(c.two_point[static_cast<std::size_t>(a)][static_cast<std::size_t>(r)], both, 1e-5)
            << a << " " << k;
        EXPECT_NEAR(c.lineal_path[static_cast<std::size_t>(a)][static_cast<std::size_t>(r)], whole, 1e-12)
            << a << " " << k;
      }
    double sum = 0, length = 0, count = 0;  // all segments of 3 ± 1/2 mm
    for (int z = -2; z <= 2; ++z)
      for (int y = -3; y <= 3; ++y)
        for (int x = -4; x <= 4; ++x) {
          const double r = Vec3(x, 1.5 * y, 2 * z).norm();
          if (z < 0 || r < 2.5 || r >= 3.5) continue;
          sum += shares({x, y, z}).first, length += r, ++count;
        }
    EXPECT_NEAR(c.mean[3], sum / count, 1e-5);
    EXPECT_NEAR(c.length[3], length / count, 1e-9);
  }
}

// Layers of 6 of 16 voxels across x.
TEST(Measure3DCorrelation, OfALaminateIsATriangleWave) {
  const Raster r = test::raster_of(Vec3i(64, 20, 36), Vec3::Constant(0.5), true,
                                   [](int x, int, int) { return x % 16 < 6 ? x / 16 : -1; });
  const Correlation c = correlate(r, test::kPlenty, {});
  ASSERT_EQ(c.mean.size(), 11u);
  for (std::size_t k = 0; k < c.mean.size(); ++k) {
    const auto distance = static_cast<double>(std::min(k % 16, 16 - k % 16));
    EXPECT_NEAR(c.two_point[0][k], std::max(0.0, 6 - distance) / 16, 1e-6) << k;
    EXPECT_NEAR(c.two_point[1][k], 6.0 / 16, 1e-6);
    EXPECT_NEAR(c.two_point[2][k], 6.0 / 16, 1e-6);
    EXPECT_NEAR(c.lineal_path[0][k], std::max(0.0, 6 - static_cast<double>(k)) / 16, 1e-12);
    EXPECT_NEAR(c.lineal_path[1][k], 6.0 / 16, 1e-12);
  }
  // 8 borders of 10 × 18 mm in 32 mm. Planes along the axes are the worst case of 13 directions.
  const double exact = 8 * 10 * 18.0;
  EXPECT_NEAR(test::surface_of(r) / exact, 0.927, 0.003);
  EXPECT_TRUE(touches_of(r, {}).empty());
}

// n points of a Poisson process with a fixed number of points, in volume V: a set of volume v has none of
// them with the probability (1 − v/V)ⁿ. A segment is in the pores if no center is within R of its ends, or of
// any of its points.
TEST(Measure3DCorrelation, OfABooleanModelIsExponential) {
  constexpr int n = 80, count = 500;
  constexpr double radius = 6, volume = n * n * n;
  const double ball = 4.0 / 3 * M_PI * radius * radius * radius;
  const auto empty = [&](double v) { return std::pow(1 - v / volume, count); };
  const auto both_ends = [&](double r) {
    return empty(r < 2 * radius ? ball + M_PI * (radius * radius * r - r * r * r / 12) : 2 * ball);
  };
  std::vector<double> two(40, 0), path(40, 0), length(40, 0);
  constexpr int kSeeds = 6;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Raster pores =
        complement(test::boolean_model(n, radius, count, 10 + static_cast<std::uint64_t>(seed)));
    const Correlation c = correlate(pores, test::kPlenty, {});
    for (std::size_t k = 0; k < two.size(); ++k) {
      two[k] += c.mean[k] / kSeeds;
      length[k] = c.length[k];
      for (std::size_t a = 0; a < 3; ++a) path[k] += c.lineal_path[a][k] / kSeeds / 3;
    }
  }
  // The share of pores has a standard deviation of 0.006 over the six models.
  for (std::size_t k = 0; k < two.size(); ++k) {
    EXPECT_NEAR(two[k], both_ends(length[k]), 0.018) << k;
    EXPECT_NEAR(path[k], empty(ball + M_PI * radius * radius * static_cast<double>(k)), 0.018) << k;
  }
  // The shape of the functions is known much better than their height.
  EXPECT_NEAR(two[6] / two[0], both_ends(length[6]) / empty(ball), 0.02);
  EXPECT_NEAR(path[6] / path[0], empty(ball + 6 * M_PI * radius * radius) / empty(ball), 0.02);
}

// Neighbors at a distance of r differ with the probability 2(p − S2(r)), where p = S2(0) is the share of
// pores; the area per volume is 4(p − S2(r))/r, averaged over the 13 directions with the weights of Lang,
// Ohser and Hilfer 2001.
TEST(Measure3DSurfaces, OfABooleanModel) {
  constexpr int n = 80, count = 500;
  constexpr double radius = 6, volume = n * n * n;
  const double ball = 4.0 / 3 * M_PI * radius * radius * radius;
  double found = 0;
  for (std::uint64_t seed = 10; seed < 16; ++seed)
    found += test::surface_of(test::boolean_model(n, radius, count, seed)) / volume / 6;
  const auto empty = [&](double v) { return std::pow(1 - v / volume, count); };
  const auto area = [&](double r) {
    return 4 * (empty(ball) - empty(ball + M_PI * (radius * radius * r - r * r * r / 12))) / r;
  };
  const double expected =
      6 * 0.045778 * area(1) + 12 * 0.036981 * area(std::sqrt(2.0)) + 8 * 0.035196 * area(std::sqrt(3.0));
  EXPECT_NEAR(found / expected, 1, 0.01);
  // The surface itself: voxels miss the dents where balls meet.
  const double exact = count * 4 * M_PI * radius * radius / volume * std::pow(1 - ball / volume, count - 1);
  EXPECT_NEAR(found / exact, 0.93, 0.02);
}

TEST(Measure3DSurfaces, OfABallWithAnyVoxels) {
  const double radius = 6;
  for (const Vec3& spacing : {Vec3(0.5, 0.5, 0.5), Vec3(0.4, 0.5, 0.7)}) {
    const Vec3i n(40, 34, 30);
    const Raster r = test::raster_of(n, spacing, true, [&](int x, int y, int z) {
      const Vec3 p = (Vec3(x, y, z) + Vec3::Constant(0.5)).cwiseProduct(spacing) - Vec3(8.1, 8.2, 7.4);
      return p.norm() < radius ? 0 : -1;
    });
    EXPECT_NEAR(test::surface_of(r) / (4 * M_PI * radius * radius), 1, 0.02);
  }
}

TEST(Measure3DSubvolumes, OfABooleanModelVaryAsItsIntegralRangeSays) {
  constexpr int n = 96, count = 1700, kSeeds = 8;
  constexpr double radius = 4, volume = n * n * n;
  const double ball = 4.0 / 3 * M_PI * radius * radius * radius;
  const double pores = std::exp(-count * ball / volume);
  // ∫(S2 − φ²)dh / φ(1 − φ) of an infinite Boolean model
  double exact = 0;
  constexpr int kSteps = 4000;
  for (int k = 0; k < kSteps; ++k) {
    const double r = 2 * radius * (k + 0.5) / kSteps;
    const double common = ball - M_PI * (radius * radius * r - r * r * r / 12);
    exact += 4 * M_PI * r * r * (pores * pores * std::exp(count * common / volume) - pores * pores) * 2 *
             radius / kSteps;
  }
  exact /= pores * (1 - pores);
  double range = 0, measured = 0, expected = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Raster model = test::boolean_model(n, radius, count, seed);
    const Representative r = representative_volume(model, 0.1, {});
    EXPECT_NEAR(r.integral_range_error / r.integral_range, 0.25, 1e-9);
    EXPECT_NEAR(r.edge, std::cbrt(400 * (1 - model.fraction()) / model.fraction() * r.integral_range), 1e-6);
    range += r.integral_range / kSeeds;
    measured += std::pow(r.table[0].deviation, 2) / kSeeds;  // cubes of half the edge
    EXPECT_NEAR(r.table[0].edge, 48, 1e-9);
    EXPECT_NEAR(r.table[0].count, 8, 1e-9);
    expected += pores * (1 - pores) * exact / std::pow(48.0, 3) * (1 - 1 / 8.0) / kSeeds;
  }
  // Eight estimates with standard errors of 25 % and, of the variance in eight cubes, at most 54 %.
  EXPECT_NEAR(range / exact, 1, 0.25);
  EXPECT_NEAR(measured / expected, 1, 0.5);
}

TEST(Measure3DSubvolumes, WithoutVarianceAreAllZero) {
  const Raster full = test::raster_of(Vec3i(12, 12, 12), Vec3::Ones(), true, [](int, int, int) { return 1; });
  const Representative r = representative_volume(full, 0.05, {});
  EXPECT_EQ(r.integral_range, 0);
  EXPECT_TRUE(r.table.empty());
}

TEST(Measure3DCorrelation, RefusesMoreThanItsMemory) {
  const Raster r = test::raster_of(Vec3i(16, 16, 16), Vec3::Ones(), true, [](int, int, int) { return 1; });
  EXPECT_EQ(test::code_of([&] { correlate(r, 8 * 16 * 16 * 16 - 1, {}); }), "too-large");
}

}  // namespace
}  // namespace terrazzo

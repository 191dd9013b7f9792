// Surface, curvature and Euler number against closed forms, counted cells and Boolean models.
#include "nodes/packing/measure3d/minkowski.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "tests/nodes/packing/measure3d/blocks.h"

namespace terrazzo {
namespace {
using namespace measure3d;
using test::densities_of;

using Inside = std::function<bool(const Vec3&)>;

Raster shape(const Vec3i& n, const Vec3& spacing, bool periodic, const Inside& inside) {
  return test::raster_of(n, spacing, periodic, [&](int x, int y, int z) {
    return inside((Vec3(x, y, z) + Vec3::Constant(0.5)).cwiseProduct(spacing)) ? 0 : -1;
  });
}

// In the volume of the cubes of voxels. As binder, voxels are connected by their faces only.
double euler_of(const Raster& r, Phase phase = Phase::Particles) {
  const Vec3i cubes = r.box.size - Vec3i::Constant(r.box.periodic ? 0 : 1);
  return densities_of(r, phase).euler * static_cast<double>(voxels_in(cubes)) * r.voxel_volume();
}

TEST(Measure3DMinkowski, OfABall) {
  const double radius = 6;
  for (const Vec3& spacing : {Vec3(0.4, 0.4, 0.4), Vec3(0.4, 0.5, 0.3)})
    for (const bool periodic : {true, false}) {
      const Raster r = shape({48, 40, 60}, spacing, periodic,
                             [&](const Vec3& p) { return (p - Vec3(9.1, 8.2, 9)).norm() < radius; });
      const auto found = densities_of(r);
      const Vec3i cubes = r.box.size - Vec3i::Constant(periodic ? 0 : 1);
      const double volume = static_cast<double>(voxels_in(cubes)) * r.voxel_volume();
      EXPECT_NEAR(found.surface * volume / (4 * M_PI * radius * radius), 1, 0.02);
      EXPECT_NEAR(found.curvature * volume / (4 * M_PI * radius), 1, 0.02);
      EXPECT_NEAR(found.euler * volume, 1, 1e-9);
      EXPECT_NEAR(euler_of(r, Phase::Binder), 1, 1e-9);
    }
}

TEST(Measure3DMinkowski, EulerNumbersOfATorusAShellAndTheirLike) {
  const Vec3i n(40, 40, 40);
  const auto euler = [&](const Inside& inside, bool periodic = true) {
    const Raster r = shape(n, Vec3::Ones(), periodic, inside);
    EXPECT_NEAR(euler_of(r), euler_of(r, Phase::Binder), 1e-9);  // no voxels that touch by corners
    return euler_of(r);
  };
  const auto from_axis = [](const Vec3& p) { return std::hypot(p.x() - 20, p.y() - 20); };
  const auto from_center = [](const Vec3& p) { return (p - Vec3::Constant(20)).norm(); };
  for (const bool periodic : {true, false}) {
    EXPECT_NEAR(euler([&](const Vec3& p) { return std::hypot(from_axis(p) - 12, p.z() - 20) < 5; }, periodic),
                0, 1e-9);
    EXPECT_NEAR(euler([&](const Vec3& p) { return from_center(p) < 14 && from_center(p) > 8; }, periodic), 2,
                1e-9);
  }
  EXPECT_NEAR(euler([&](const Vec3& p) { return from_axis(p) < 8; }), 0, 1e-9);  // a rod without ends
  EXPECT_NEAR(euler([&](const Vec3& p) { return p.z() < 8; }), 0, 1e-9);
  EXPECT_NEAR(euler([&](const Vec3& p) { return from_center(p) > 9; }), 1,
              1e-9);  // a box of period 3-torus, χ 0, less a ball
}

TEST(Measure3DMinkowski, CornersConnectTheParticlesButNotTheBinder) {
  for (const auto& [second, touching] :
       {std::pair(Vec3i(2, 2, 2), 1), std::pair(Vec3i(2, 2, 1), 1), std::pair(Vec3i(3, 2, 2), 2)}) {
    const Raster r = test::raster_of({6, 6, 6}, Vec3::Ones(), true, [&, &v = second](int x, int y, int z) {
      return Vec3i(x, y, z) == Vec3i(1, 1, 1) || Vec3i(x, y, z) == v ? 0 : -1;
    });
    EXPECT_NEAR(euler_of(r), touching, 1e-9);
    EXPECT_NEAR(euler_of(r, Phase::Binder), 2, 1e-9);
  }
}

// Vertices − edges + faces − voxels of the union of closed voxels, each cell counted once by its doubled
// coordinates.
double euler_by_cells(const Raster& r) {
  std::set<std::array<int, 3>> cells;
  for (int z = 0; z < r.box.size.z(); ++z)
    for (int y = 0; y < r.box.size.y(); ++y)
      for (int x = 0; x < r.box.size.x(); ++x)
        if (r.in[r.index(x, y, z)])
          for (int k = 0; k < 27; ++k)
            cells.insert({wrap_index(2 * x + k % 3, 2 * r.box.size.x()),
                          wrap_index(2 * y + k / 3 % 3, 2 * r.box.size.y()),
                          wrap_index(2 * z + k / 9, 2 * r.box.size.z())});
  double sum = 0;
  for (const auto& c : cells) sum += (c[0] % 2 + c[1] % 2 + c[2] % 2) % 2 == 0 ? 1 : -1;
  return sum;
}

Raster random_raster(const Vec3i& n, bool periodic, double share, std::uint64_t seed) {
  return test::raster_of(n, Vec3(0.5, 0.7, 0.6), periodic, [&](int x, int y, int z) {
    return Random(seed, 2, voxel_at(x, y, z, n)).uniform() < share ? 0 : -1;
  });
}

TEST(Measure3DMinkowski, OfRandomVoxelsCountCellsAndAgreeWithTheRest) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Raster r = random_raster({7, 6, 9}, true, 0.05 * static_cast<double>(seed), seed);
    EXPECT_NEAR(euler_of(r), euler_by_cells(r), 1e-9) << seed;
    Raster rest = r;
    for (auto& v : rest.in) v = !v;
    const auto a = densities_of(r), b = densities_of(rest, Phase::Binder);
    EXPECT_NEAR(a.euler, b.euler, 1e-9);
    EXPECT_NEAR(a.curvature, -b.curvature, 1e-9);
    EXPECT_NEAR(a.surface, b.surface, 1e-9);
  }
}

TEST(Measure3DMinkowski, OfSetsThatDoNotTouchAddUp) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Vec3i n(8, 8, 16);
    const Raster all = random_raster(n, true, 0.4, seed);
    const auto part = [&](bool low, bool high) {
      return test::raster_of(n, Vec3::Ones(), true, [&](int x, int y, int z) {
        const bool in = (z < 7 && low) || (z > 7 && z < 15 && high);
        return in && all.in[all.index(x, y, z)] ? 0 : -1;
      });
    };
    const auto both = densities_of(part(true, true)), low = densities_of(part(true, false)),
               high = densities_of(part(false, true));
    EXPECT_NEAR(both.euler, low.euler + high.euler, 1e-9);
    EXPECT_NEAR(both.surface, low.surface + high.surface, 1e-9);
    EXPECT_NEAR(both.curvature, low.curvature + high.curvature, 1e-9);
  }
}

// Parts that share a plane of voxels have the cubes of the whole, each once.
TEST(Measure3DMinkowski, HaveNoBiasFromTheBorder) {
  const Raster whole = random_raster({12, 15, 8}, true, 0.3, 4);
  const auto expected = count_cubes(classes_of_phase(whole, Phase::Particles), {});
  std::vector<Cubes> sum(2, Cubes{});
  for (int part = 0; part < 3 * 3 * 2; ++part) {
    const Vec3i from(part % 3 * 4, part / 3 % 3 * 5, part / 9 * 4);
    const Raster r = test::raster_of({5, 6, 5}, whole.box.spacing, false, [&](int x, int y, int z) {
      return whole.in[whole.index((from.x() + x) % 12, (from.y() + y) % 15, (from.z() + z) % 8)] ? 0 : -1;
    });
    const auto cubes = count_cubes(classes_of_phase(r, Phase::Particles), {});
    for (std::size_t k = 0; k < 2; ++k)
      for (std::size_t c = 0; c < 256; ++c) sum[k][c] += cubes[k][c];
  }
  EXPECT_EQ(sum, expected);
  const Raster flat = random_raster({9, 9, 1}, false, 0.5, 1);
  EXPECT_TRUE(std::isnan(densities_of(flat).euler));
}

// Of `count` random balls in a volume, per voxel. The voxels within `radius` of the corners of a block of
// 1, 2, 4 or 8 voxels have the volumes V, V + S1, V + 2S1 + S2, V + 3S1 + 3S2 + 1, where S1 and S2 are the
// parts of a ball within half a voxel of a plane and of an axis.
double digital_euler(double radius, int count, double volume) {
  double axis = 0;
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const double x = (i % kSteps + 0.5) / kSteps - 0.5, y = (i / kSteps + 0.5) / kSteps - 0.5;
    axis += 2 * std::sqrt(radius * radius - x * x - y * y) / kSteps / kSteps;
  }
  const double ball = 4.0 / 3 * M_PI * std::pow(radius, 3), plane = M_PI * (radius * radius - 1.0 / 12);
  const auto hit = [&](double v) { return 1 - std::pow(1 - v / volume, count); };
  return hit(ball + 3 * plane + 3 * axis + 1) - 3 * hit(ball + 2 * plane + axis) + 3 * hit(ball + plane) -
         hit(ball);
}

// Miles 1976: of balls with the mean volume v, surface s and curvature integral m per volume, and number N.
// Creases where balls meet are counted by voxels as if they were finer than they are, at any resolution: the
// Euler number of the voxels tends to N − 3/2 · ms/4π + …  (Ohser, Nagel and Schladitz 2003).
TEST(Measure3DMinkowski, OfBooleanModels) {
  constexpr int n = 80, kSeeds = 6;
  constexpr double radius = 6, volume = n * n * n;
  for (const int count : {200, 500}) {
    const double number = count / volume, v = number * 4.0 / 3 * M_PI * std::pow(radius, 3),
                 s = number * 4 * M_PI * radius * radius, m = number * 4 * M_PI * radius;
    MinkowskiDensities mean{0, 0, 0};
    double fraction = 0;
    for (std::uint64_t seed = 10; seed < 10 + kSeeds; ++seed) {
      const Raster model = test::boolean_model(n, radius, count, seed);
      const auto d = densities_of(model);
      fraction += model.fraction() / kSeeds;
      mean.surface += d.surface / kSeeds;
      mean.curvature += d.curvature / kSeeds;
      mean.euler += d.euler / kSeeds;
    }
    const double surface = s * std::exp(-v), curvature = (m - M_PI * M_PI / 32 * s * s) * std::exp(-v),
                 euler = (number - m * s / (4 * M_PI) + M_PI / 384 * s * s * s) * std::exp(-v);
    EXPECT_NEAR(fraction, 1 - std::exp(-v), 0.012);  // two standard deviations
    EXPECT_NEAR(mean.surface / surface, 1, 0.09);    // voxels miss the dents where balls meet
    EXPECT_NEAR(mean.curvature, curvature, 0.1 * m);
    EXPECT_NEAR(mean.euler, digital_euler(radius, count, volume), 0.05 * number);
    EXPECT_LT(mean.euler, euler);
  }
}

}  // namespace
}  // namespace terrazzo

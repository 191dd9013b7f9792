// The detail of binder and particles at any point of a packing.
#include <gtest/gtest.h>

#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"
#include "nodes/data/detail.h"
#include "nodes/data/particles.h"
#include "nodes/detail/residual/outline_depth.h"
#include "nodes/detail/residual/residual_field.h"
#include "runtime/random.h"

namespace terrazzo {
namespace {
using residual::ResidualField;

// Tiles of white noise: deviation 0.1 in the binder, 0.2 and 0.4 in the groups of dark and light particles.
Detail noise_detail(int size = 16) {
  Detail d;
  d.pixel_size = 0.5;
  d.size = size;
  for (int k = 0; k < 3; ++k) {
    Detail::Phase phase;
    phase.color = Vec3f::Constant(k == 2 ? 0.8f : 0.1f);
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(size) * size * size; ++i)
      phase.tile.push_back(Vec3f::Constant(
          static_cast<float>(0.1 * (1 << k) * Random(1, static_cast<std::uint64_t>(k), i).normal())));
    d.phases.push_back(std::move(phase));
  }
  return d;
}

Particles two_particles() {
  Particles p;
  p.box = Vec3(30, 24, 27);
  p.resize(2);
  p.position = {Vec3(2, 12, 13), Vec3(20, 12, 13)};
  p.size = {10, 10};
  p.color = {Vec3f::Constant(0.15f), Vec3f::Constant(0.7f)};
  return p;
}

double deviation(const ResidualField& f, int particle, const Vec3& center) {
  double square = 0;
  constexpr int n = 4000;
  for (std::uint64_t k = 0; k < n; ++k) {
    Random r(2, 2, k);
    const Vec3f at = (center + Vec3(r.uniform(-5, 5), r.uniform(-5, 5), r.uniform(-5, 5))).cast<float>();
    square += f.at(at, particle).x() * f.at(at, particle).x();
  }
  return std::sqrt(square / n);
}

TEST(PhaseField, EveryPhaseHasItsOwnTileAndTheBoxsPeriod) {
  const Particles p = two_particles();
  const ResidualField field(noise_detail(), p, 0);
  // Between voxels the spline of white noise has less than its deviation at voxels.
  const double binder = deviation(field, -1, Vec3(11, 12, 13)), dark = deviation(field, 0, p.position[0]),
               light = deviation(field, 1, p.position[1]);
  const auto scale = [](float linear) {
    return Detail::particle_scale(linear_to_srgb(Vec3f::Constant(linear)));
  };
  EXPECT_NEAR(dark / binder, 2 * scale(0.15f), 0.25 * scale(0.15f));
  EXPECT_NEAR(light / binder, 4 * scale(0.7f), 0.5 * scale(0.7f));
  for (std::uint64_t k = 0; k < 300; ++k) {
    Random r(3, 3, k);
    const Vec3f at(float(r.uniform(0, 30)), float(r.uniform(0, 24)), float(r.uniform(0, 27)));
    for (const int particle : {-1, 0, 1})
      for (const Vec3f& period : {Vec3f(30, 0, 0), Vec3f(0, -24, 0), Vec3f(-30, 24, 27)})
        EXPECT_LT((field.at(at, particle) - field.at(at + period, particle)).norm(), 0.02f) << particle;
  }
}

TEST(PhaseField, ParticlesOfAGroupShowDifferentParts) {
  Particles p = two_particles();
  p.color[1] = p.color[0];
  const ResidualField field(noise_detail(), p, 0);
  double product = 0, square = 0;
  for (std::uint64_t k = 0; k < 4000; ++k) {
    Random r(4, 4, k);
    const Vec3 offset(r.uniform(-4, 4), r.uniform(-4, 4), r.uniform(-4, 4));
    const float a = field.at((p.position[0] + offset).cast<float>(), 0).x(),
                b = field.at((p.position[1] + offset).cast<float>(), 1).x();
    product += a * b;
    square += a * a;
  }
  EXPECT_LT(std::abs(product / square), 0.1);
}

TEST(PhaseField, RimsContrastsAndSlopesAreApplied) {
  Particles p = two_particles();
  Detail d = noise_detail();
  for (auto& phase : d.phases)
    for (Vec3f& v : phase.tile) v.setZero();
  d.phases[1].rims = {{1, {Vec3f::Constant(0.3f), Vec3f::Constant(0.1f), Vec3f::Zero()}}};
  d.phases[0].rims = {{1, {Vec3f::Constant(-0.2f), Vec3f::Zero()}}};
  const Vec3f at = p.position[0].cast<float>();
  const ResidualField rims(d, p, 0);
  const float dark = Detail::particle_scale(linear_to_srgb(p.color[0]));
  EXPECT_NEAR(rims.at(at, 0, 0.25f).x(), 0.3f * dark, 1e-5f);  // half a pixel deep
  EXPECT_NEAR(rims.at(at, 0, 0.5f).x(), 0.2f * dark, 1e-5f);   // between two bins
  EXPECT_NEAR(rims.at(at, 0, 100).x(), 0, 1e-5f);
  EXPECT_NEAR(rims.at(at, -1, 0.25f).x(), -0.2f, 1e-5f);
  for (auto& phase : d.phases) phase.rims.clear();
  d.phases[1].slope = 0.1f;
  const ResidualField slopes(d, p, 0);
  const float up = slopes.at(at + Vec3f(2, 1, 0), 0).x(), down = slopes.at(at - Vec3f(2, 1, 0), 0).x();
  EXPECT_GT(std::abs(up - down), 1e-4f);
  // Odd about the center, up to the shift of the center to the nearest voxel.
  EXPECT_NEAR(up - down, 2 * (slopes.at(at + Vec3f(2, 1, 0), 0).x() - slopes.at(at, 0).x()), 1e-3f);
  Detail loud = noise_detail();
  loud.profile_color = {Vec3f::Constant(0.15f), Vec3f::Constant(0.7f)};
  loud.profile_size = {1, 1};
  loud.profile_contrast = {{3, 3}, {1, 1}};
  const double plain = deviation(ResidualField(noise_detail(), p, 0), 0, p.position[0]);
  EXPECT_NEAR(deviation(ResidualField(loud, p, 0), 0, p.position[0]) / plain, 3, 1e-3);
}

TEST(PhaseField, SlopesAddAtMostOneDeviation) {
  Particles p;
  p.box.setConstant(100);
  p.resize(200);
  for (std::size_t k = 0; k < p.count(); ++k) {
    p.position[k].setConstant(50);
    p.size[k] = 2;
    p.color[k].setConstant(0.5f);
  }
  Detail d = noise_detail();
  for (auto& phase : d.phases)
    for (Vec3f& v : phase.tile) v.setZero();
  for (auto& phase : d.phases) phase.slope = 0.1f;
  const ResidualField field(d, p, 0);
  const float scale = Detail::particle_scale(linear_to_srgb(p.color[0]));
  const Vec3f center = Vec3f::Constant(50.25f);  // the center of a voxel
  float most = 0;
  double squares = 0;
  for (std::size_t k = 0; k < p.count(); ++k) {
    const float far = field.at(center + Vec3f(40, 0, 0), static_cast<int>(k)).x() / scale;
    EXPECT_LE(std::abs(far), 0.1001f);
    most = std::max(most, std::abs(far));
    const float near = field.at(center + Vec3f(0.5f, 0, 0), static_cast<int>(k)).x() / scale;
    squares += near * near;
  }
  EXPECT_GT(most, 0.099f);
  // At half a radius, slopes add half of a deviation, of which the limit takes little.
  const double deviation = std::sqrt(squares / static_cast<double>(p.count()));
  EXPECT_GT(deviation, 0.038);
  EXPECT_LT(deviation, 0.05);
}

TEST(PhaseField, RimsDependOnTheSizeOfTheProfile) {
  const Particles p = two_particles();
  Detail d = noise_detail();
  for (auto& phase : d.phases)
    for (Vec3f& v : phase.tile) v.setZero();
  d.phases[0].rims = {{1, {Vec3f::Constant(0.1f)}}, {4, {Vec3f::Constant(0.3f), Vec3f::Constant(0.1f)}}};
  const ResidualField field(d, p, 0);
  const Vec3f at = p.position[0].cast<float>();
  EXPECT_NEAR(field.at(at, -1, 0.1f, 0.5f).x(), 0.1f, 1e-5f);  // smaller than all
  EXPECT_NEAR(field.at(at, -1, 0.1f, 2).x(), 0.2f, 1e-5f);     // halfway by the logarithm
  EXPECT_NEAR(field.at(at, -1, 0.1f, 9).x(), 0.3f, 1e-5f);
  EXPECT_NEAR(field.at(at, -1, 50, 9).x(), 0.1f, 1e-5f);  // the last bin holds beyond
  EXPECT_NEAR(field.at(at, -1, 0.1f).x(), 0.3f, 1e-5f);   // unknown: the middle one, here the second
}

TEST(PhaseField, ChromaHasAContrastOfItsOwn) {
  const Particles p = two_particles();
  Detail d = noise_detail();
  for (std::uint64_t i = 0; i < d.phases[1].tile.size(); ++i)
    d.phases[1].tile[i] += Vec3f(1, 0, -1) * static_cast<float>(0.1 * Random(1, 9, i).normal());
  d.profile_color = {p.color[0]};
  d.profile_size = {8};
  d.profile_contrast = {{1, 0.25f}};
  const ResidualField field(d, p, 0);
  d.profile_contrast = {{1, 1}};
  const ResidualField plain(d, p, 0);
  for (int k = 0; k < 20; ++k) {
    const Vec3f at = (p.position[0] + Vec3(0.1 * k, 0.3, 0)).cast<float>();
    const Vec3f a = field.at(at, 0), b = plain.at(at, 0);
    EXPECT_NEAR(a.mean(), b.mean(), 1e-5f);
    EXPECT_NEAR((a - Vec3f::Constant(a.mean())).norm(), 0.25f * (b - Vec3f::Constant(b.mean())).norm(),
                1e-5f);
  }
}

TEST(PhaseField, ZonesHaveAContrastOfTheirOwn) {
  const Particles p = two_particles();
  Detail d = noise_detail(), zones = noise_detail();
  for (std::size_t k = 0; k < d.phases.size(); ++k) {
    d.phases[k].broad = noise_detail().phases[2 - k].tile;
    zones.phases[k].tile = d.phases[k].broad;
  }
  d.profile_color = {p.color[0]}, d.profile_size = {8}, d.profile_contrast = {{0.5f, 0.5f}},
  d.profile_broad = {{2, 2}};
  const ResidualField field(d, p, 0), grain(noise_detail(), p, 0), only(zones, p, 0);
  for (int k = 0; k < 20; ++k) {
    const Vec3f in = (p.position[0] + Vec3(0.1 * k, 0.3, 0)).cast<float>(),
                out(11, 12, 13 + 0.1f * static_cast<float>(k));
    EXPECT_NEAR(field.at(in, 0).x(), 0.5f * grain.at(in, 0).x() + 2 * only.at(in, 0).x(), 2e-4f);
    EXPECT_NEAR(field.at(out, -1).x(), grain.at(out, -1).x() + only.at(out, -1).x(),
                2e-4f);  // the binder has no contrast
  }
}

TEST(PhaseField, AParticleShowsTheGroupOfItsProfile) {
  const Particles p = two_particles();  // the first one's color is near to that of the dark group
  Detail d = noise_detail();
  d.profile_color = {p.color[0]};
  d.profile_size = {8};
  d.profile_contrast = {{1, 1}};
  d.profile_group = {2};
  EXPECT_NEAR(deviation(ResidualField(d, p, 0), 0, p.position[0]) /
                  deviation(ResidualField(noise_detail(), p, 0), 0, p.position[0]),
              2, 0.2);
}

TEST(PhaseField, ASimilarProfileHasTheSizeToo) {
  Particles p = two_particles();
  Detail d = noise_detail();
  d.profile_color = {p.color[0], p.color[0]};
  d.profile_size = {1, 8};
  d.profile_contrast = {{3, 3}, {1, 1}};
  const double plain = deviation(ResidualField(noise_detail(), p, 0), 0, p.position[0]);
  EXPECT_NEAR(deviation(ResidualField(d, p, 0), 0, p.position[0]) / plain, 1, 1e-3);
  p.size[0] = 1.2;
  EXPECT_GT(deviation(ResidualField(d, p, 0), 0, p.position[0]) / plain, 2.5);
}

TEST(SplineTile, EitherValuesOrTheirPowerAreKept) {
  constexpr int n = 24;
  std::vector<Vec3f> values;
  double given = 0;
  for (std::uint64_t i = 0; i < n * n * n; ++i) {
    values.push_back(Vec3f::Constant(static_cast<float>(Random(1, 4, i).normal())));
    given += values.back().x() * values.back().x() / (n * n * n);
  }
  const residual::SplineTile through(values, Vec3i::Constant(n), residual::Keep::Values),
      strong(values, Vec3i::Constant(n), residual::Keep::Power);
  for (int k = 0; k < n; ++k)
    EXPECT_NEAR(through.at(Vec3f(k, 3, 7)).x(), values[static_cast<std::size_t>((7 * n + 3) * n + k)].x(),
                2e-3f);
  double a = 0, b = 0;
  constexpr int kPlaces = 60000;
  for (std::uint64_t k = 0; k < kPlaces; ++k) {
    Random r(3, 5, k);
    const Vec3f at = Vec3(r.uniform(0, n), r.uniform(0, n), r.uniform(0, n)).cast<float>();
    a += through.at(at).x() * through.at(at).x() / kPlaces,
        b += strong.at(at).x() * strong.at(at).x() / kPlaces;
  }
  EXPECT_LT(a / given, 0.7);
  EXPECT_NEAR(b / given, 1, 0.03);
}

TEST(PhaseField, CoarseVoxelsKeepTheContrastOfReducedPictures) {
  const Particles p = two_particles();
  const double fine = deviation(ResidualField(noise_detail(24), p, 0), -1, Vec3(11, 12, 13)),
               coarse = deviation(ResidualField(noise_detail(24), p, 1.5), -1, Vec3(11, 12, 13));
  // A picture of white noise whose pixels become three times as long has a third of the deviation.
  EXPECT_LT(coarse / fine, 0.6);
  EXPECT_GT(coarse / fine, 0.25);
}

TEST(PhaseField, GrayDetailIsExactlyGray) {
  Detail d = noise_detail();
  for (auto& phase : d.phases)
    for (std::size_t i = 0; i < phase.tile.size(); ++i)
      phase.tile[i].y() += 1e-4f * static_cast<float>(i % 7);
  d.gray = true;
  const ResidualField field(d, two_particles(), 0);
  for (float x = 0; x < 30; x += 0.37f) {
    const Vec3f v = field.at(Vec3f(x, 3, 4), -1);
    EXPECT_EQ(v.x(), v.y());
    EXPECT_EQ(v.x(), v.z());
  }
}

TEST(PhaseField, EmptyDetailIsAnError) {
  try {
    ResidualField(Detail(), two_particles(), 0);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.diagnostic().code, "bad-detail");
  }
}

TEST(OutlineDepth, IsTheDistanceToTheNearestOutline) {
  std::vector<std::int32_t> ids(40 * 40, 0);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 10; ++x) ids[static_cast<std::size_t>(y) * 40 + x] = 7;
  const auto open = residual::outline_depth(ids.data(), 40, 40, false),
             closed = residual::outline_depth(ids.data(), 40, 40, true);
  const std::size_t row = 20 * 40;
  EXPECT_NEAR(open[row + 9], 0.5, 1e-6);
  EXPECT_NEAR(open[row + 10], 0.5, 1e-6);
  EXPECT_NEAR(open[row + 0], 9.5, 1e-3);
  EXPECT_NEAR(closed[row + 0], 0.5, 1e-6);  // the outline on the picture's edge
  EXPECT_NEAR(closed[row + 39], 0.5, 1e-6);
  ids[row + 30] = 4;
  const auto nearest = residual::nearest_outlines(ids.data(), 40, 40, false);
  const auto sizes = residual::sizes_of_particles(ids, 0.5);
  ASSERT_EQ(sizes.size(), 8u);
  EXPECT_EQ(sizes[0], 0);
  EXPECT_EQ(sizes[1], 0);  // there is no such particle
  EXPECT_NEAR(sizes[4], 0.5 * std::sqrt(4 / M_PI), 1e-6);
  EXPECT_NEAR(sizes[7], 0.5 * std::sqrt(1600 / M_PI), 1e-5);
  EXPECT_EQ(nearest.particle[row + 2], 7);
  EXPECT_EQ(nearest.particle[row + 12], 7);  // the binder belongs to the nearer one
  EXPECT_EQ(nearest.particle[row + 27], 4);
  EXPECT_EQ(nearest.particle[row + 30], 4);
  ids.assign(ids.size(), 3);
  for (const auto id : residual::nearest_outlines(ids.data(), 40, 40, true).particle) ASSERT_EQ(id, 3);
  for (const float d : residual::outline_depth(ids.data(), 40, 40, true)) ASSERT_GT(d, 40);
}

}  // namespace
}  // namespace terrazzo

// Ray marching compared with closed-form results.
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "nodes/volumes/render_volume/scene.h"
#include "nodes/volumes/render_volume/simplex.h"
#include "runtime/random.h"

namespace terrazzo::render_volume {
namespace {
using namespace render_volume;

template <class Density>
ScanField field(const Vec3i& n, const Vec3& spacing, Density&& density) {
  std::vector<float> v;
  for (int z = 0; z < n.z(); ++z)
    for (int y = 0; y < n.y(); ++y)
      for (int x = 0; x < n.x(); ++x)
        v.push_back(static_cast<float>(density((Vec3(x, y, z) + Vec3::Constant(0.5)).cwiseProduct(spacing))));
  return scan_field(n, spacing, v);
}

// A ball of density 100 in air, with an edge a few voxels wide.
ScanField ball(int n, double radius) {
  return field(Vec3i(n, n, n), Vec3::Ones(), [&](const Vec3& p) {
    return -1000 + 1100 * std::clamp(0.5 + (radius - (p - Vec3::Constant(0.5 * n)).norm()) / 3, 0.0, 1.0);
  });
}

Look small() {
  Look l;
  l.width = l.height = 48;
  l.modulation = 0;
  l.background = Vec3f::Zero();
  return l;
}

std::vector<Vec3f> picture(const Scene& scene, FrameCounts& counts, double azimuth = -41) {
  return march(scene, frame_of(scene, azimuth), Bricks(scene.scan, scene.intervals), counts);
}
std::vector<Vec3f> picture(const Scene& scene) {
  FrameCounts counts;
  return picture(scene, counts);
}

double mean_difference(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).cwiseAbs().sum() / 3;
  return sum / double(a.size());
}

// Along a ray through a slab of one tissue, the transmittance is (1 − α) to the power of the number of
// reference steps.
TEST(VolumeMarch, OpacityGoesByLength) {
  for (const double step : {0.3, 1.0, 2.0}) {
    const int n = 40;
    ScanField scan =
        field(Vec3i(n, n, n), Vec3(1, 1, 1), [](const Vec3& p) { return p.z() < 0.6 ? -10 : 50; });
    Look l = small();
    l.elevation = 80, l.step = step, l.zoom = 8;  // straight down through the middle
    l.clip = {Vec3f(0, 0, 0.25f), Vec3f(1, 1, 0.75f)};
    const double alpha = 0.0005;
    Scene scene(scan, parse_tissues({"all 0 100 #ffffff opacity=" + std::to_string(alpha)}), {}, l);
    const Frame frame = frame_of(scene, 0);
    const std::vector<Vec3f> p = picture(scene);
    const Vec3f d = frame.camera.direction(24.5f, 24.5f, 48, 48);
    const double length = 20 / -d.z();  // mm within the slab
    const double left = std::pow(1 - alpha, length / (n / 1000.0));
    const double facing = 0.38 + 0.67 * std::max(0.0f, frame.light.z());
    const Vec3f seen = p[24 * 48 + 24];
    // Near the cut face the light is that of the face, further in that of no surface; both are known.
    EXPECT_GT(seen.x(), (1 - left) * std::min(0.8, facing) - 2e-3) << step;
    EXPECT_LT(seen.x(), (1 - left) * std::max(0.8, facing) + 2e-3) << step;
    scene.look.background = Vec3f::Ones();
    const float bright = picture(scene)[24 * 48 + 24].x();
    EXPECT_NEAR(bright - seen.x(), left, 1e-3) << step;
  }
}

// A white slab of 20 mm between air, seen straight from above, with all light inside the tissue. `gap`: air
// in the slab's middle, mm. Returns the brightness at the center and the length of the slab along the ray.
struct Slab {
  double seen, length, sigma;  // extinction per mm along the view
  float facing;                // cosine between the ray and the lamp
};
Slab slab(const Vec3& lamp, double penetration, double opacity, double thickness = 20, double gap = 0) {
  const int n = 80;
  const ScanField scan = field(Vec3i(n, n, n), Vec3::Constant(0.5), [&](const Vec3& p) {
    const double z = std::abs(p.z() - 20);
    return z < gap / 2 || z > gap / 2 + thickness / 2 ? -1000 : 50;
  });
  Look l = small();
  l.elevation = 85;
  l.zoom = 40;
  l.step = 0.1;
  l.translucency = 1;
  l.penetration = penetration;
  l.lamp = lamp;
  // A narrow class, so that its borders are where the density jumps.
  Scene scene(scan, parse_tissues({"all 0 100 #ffffff opacity=" + std::to_string(opacity)}), {}, l);
  const Frame frame = frame_of(scene, 0);
  const Vec3f d = frame.camera.direction(24.5f, 24.5f, 48, 48);
  // A density is linear from −1000 to 50 over one voxel, so the class ends 0.5·50/1050 mm beyond its voxels'
  // centers.
  const double edge = 2 * (0.5 * 50 / 1050 - 0.25) * (gap > 0 ? 2 : 1);
  return {picture(scene)[24 * 48 + 24].x(), (thickness + edge) / -d.z(),
          -std::log(1 - opacity) / frame.reference_step, d.dot(frame.light)};
}

// Single scattering in a slab that is lit from behind: the integral of σ e^(−σs) (0.38 + 0.67 e^(−(L −
// s)/ℓ)).
TEST(VolumeMarch, LightPassesASlabAsBeerAndLambertSay) {
  for (const double l : {2.0, 5.0, 20.0})
    for (const double opacity : {0.0005, 0.01}) {
      const Slab s = slab(Vec3(0, 0, -1), l, opacity);
      EXPECT_NEAR(s.facing, 1, 1e-3);
      const double a = s.sigma - 1 / l;
      const double expected = 0.38 * (1 - std::exp(-s.sigma * s.length)) +
                              0.67 * s.sigma * std::exp(-s.length / l) * (1 - std::exp(-a * s.length)) / a;
      EXPECT_NEAR(s.seen, expected, 4e-3) << l << " mm, opacity " << opacity;
    }
}

// Behind an opaque surface only the light that has passed the whole thickness shows, whatever air it crosses.
TEST(VolumeMarch, ThickPartsAreDarkerAndAirCastsNoShadow) {
  const double l = 6;
  // Relative to e^(−thickness/ℓ).
  const auto passed = [&](double thickness, double gap) {
    const Slab s = slab(Vec3(0, 0, -1), l, 0.9, thickness, gap);
    return (s.seen - 0.38) / 0.67 / std::exp(-s.length / l);
  };
  EXPECT_NEAR(passed(4, 0), 1, 0.02);
  EXPECT_NEAR(passed(16, 0), 1, 0.02);
  EXPECT_NEAR(passed(4, 12), 1, 0.02);
  EXPECT_NEAR(slab(Vec3(0, 0, 1), l, 0.9).seen, 1, 0.005);  // lit from the front: 0.38 + 0.67, clamped
}

TEST(VolumeMarch, WithoutTranslucencyPenetrationDoesNothing) {
  Look l = small();
  const auto with = [&](double penetration) {
    l.penetration = penetration;
    return picture(Scene(ball(32, 11), parse_tissues({"meat -190 150 #8f3a36"}), {}, l));
  };
  EXPECT_EQ(with(1), with(100));
  l.translucency = 0.5;
  EXPECT_GT(mean_difference(with(1), with(100)), 0.003);
}

TEST(VolumeMarch, SkippingChangesNothing) {
  for (int seed = 0; seed < 3; ++seed) {
    const ScanField scan = field(Vec3i(37, 50, 29), Vec3(1, 0.8, 2.2), [&](const Vec3& p) {
      Random r(seed, 1,
               static_cast<std::uint64_t>(p.x()) / 9 + 100 * (static_cast<std::uint64_t>(p.y()) / 9) +
                   10000 * (static_cast<std::uint64_t>(p.z()) / 9));
      return r.uniform() < 0.08 ? 60 + 400 * r.uniform() : -1000;
    });
    Look l = small();
    l.azimuth = 30 + 100 * seed;
    l.elevation = -30 + 40 * seed;
    l.translucency = 0.5 * seed;
    Scene scene(scan,
                parse_tissues({"skin -600 -190 #d9a58c noise opacity=0.25", "fat -190 -30 #ead9a9",
                               "muscle -30 150 #8f3a36", "bone 150 4000 #efe6cf"}),
                {}, l);
    FrameCounts with, without;
    const auto a = picture(scene, with, l.azimuth);
    scene.look.skip_empty = false;
    const auto b = picture(scene, without, l.azimuth);
    EXPECT_LT(mean_difference(a, b), 1e-6);
    EXPECT_LT(with.samples, 3 * without.samples / 4);
    double most = 0;
    for (const auto& c : a) most = std::max<double>(most, c.x());
    EXPECT_GT(most, 0.3);
  }
}

// Between samples the path through each class is exact, so coarse steps show the same as fine ones.
TEST(VolumeMarch, CoarseStepsShowWhatFineOnesDo) {
  Look l = small();
  const auto tissues = parse_tissues({"skin -600 -190 #d9a58c opacity=0.25", "meat -190 150 #8f3a36"});
  l.step = 0.1;
  const auto fine = picture(Scene(ball(40, 14), tissues, {}, l));
  l.step = 1;
  const auto coarse = picture(Scene(ball(40, 14), tissues, {}, l));
  EXPECT_LT(mean_difference(fine, coarse), 2.0 / 255);
}

TEST(VolumeMarch, ABallIsRoundFromEverySide) {
  Look l = small();
  const Scene scene(ball(32, 10), parse_tissues({"meat -450 150 #ffffff"}), {}, l);
  std::size_t first = 0;
  for (const double azimuth : {0.0, 77.0, 180.0}) {
    FrameCounts counts;
    const auto p = picture(scene, counts, azimuth);
    std::size_t covered = 0;
    for (const auto& c : p) covered += c.x() > 0.1f;
    const Frame f = frame_of(scene, azimuth);
    const double distance = f.camera.position.norm(), pixel = 2 * f.camera.half_height / 48;
    const double radius = std::tan(std::asin(10 / distance)) / pixel;
    EXPECT_NEAR(double(covered), M_PI * radius * radius, 0.05 * M_PI * radius * radius);
    if (first == 0) first = covered;
    EXPECT_NEAR(double(covered), double(first), 0.03 * double(first));
  }
}

// Light falls off with the angle to the lamp, but a dark side is not black.
TEST(VolumeMarch, LightFollowsTheSurface) {
  Look l = small();
  l.elevation = 0;
  const Scene scene(ball(48, 18), parse_tissues({"meat -450 150 #ffffff"}), {}, l);
  const auto p = picture(scene);
  EXPECT_GT(p[19 * 48 + 20].x(), p[29 * 48 + 28].x() + 0.1f);
  EXPECT_GT(p[29 * 48 + 28].x(), 0.2f);
  for (const auto& c : p) EXPECT_LE(c.x(), 1);
}

TEST(VolumeMarch, AnEndThatCutsTissueHasOneFlatFace) {
  const ScanField scan =
      field(Vec3i(24, 24, 24), Vec3::Ones(), [](const Vec3& p) { return p.z() < 1 ? 49 : 50; });
  Look l = small();
  l.elevation = 60;
  const Scene scene(scan, parse_tissues({"meat 0 100 #808080"}), {}, l);
  const Frame f = frame_of(scene, -41);
  const auto p = picture(scene);
  // The upper face, sampled in a few places, has one brightness.
  std::vector<float> seen;
  for (const Vec3f& at : {Vec3f(0, 0, 12), Vec3f(-6, 3, 12), Vec3f(5, -6, 12)}) {
    const Eigen::Vector2f q = f.camera.project(at, 48, 48);
    seen.push_back(p[static_cast<std::size_t>(q.y()) * 48 + static_cast<std::size_t>(q.x())].x());
  }
  EXPECT_NEAR(seen[0], seen[1], 0.01);
  EXPECT_NEAR(seen[0], seen[2], 0.01);
  EXPECT_GT(seen[0], 0.1);
}

std::vector<Vec3f> stripes(int n) {
  std::vector<Vec3f> c;
  for (int i = 0; i < n * n * n; ++i)
    c.push_back(i % n < n / 2 ? Vec3f(0.8f, 0.2f, 0.2f) : Vec3f(0.2f, 0.2f, 0.6f));
  return c;
}

TEST(VolumeMarch, ATextureKeepsItsMeanAtEveryScale) {
  const ScanField scan = ball(32, 11);
  Look l = small();
  const auto tissues = parse_tissues({"meat -450 150 #000000 texture"});
  const SolidTexture texture(Vec3i(12, 12, 12), 1, stripes(12));
  l.textured = false;
  const auto plain = picture(Scene(scan, tissues, {texture}, l));
  l.textured = true;
  for (const double scale : {0.01, 0.2, 1.0}) {
    l.scales = {scale, scale, scale};
    const auto textured = picture(Scene(scan, tissues, {texture}, l));
    Vec3f a = Vec3f::Zero(), b = Vec3f::Zero();
    for (std::size_t i = 0; i < plain.size(); ++i) {
      a += plain[i];
      b += textured[i];
    }
    EXPECT_LT((a - b).norm(), (scale < 1 ? 0.06 : 0.15) * a.norm()) << scale;
    if (scale == 0.01) {
      EXPECT_LT(mean_difference(plain, textured), 1e-3);  // below a pixel the texture becomes its mean
    }
    if (scale == 1.0) {
      EXPECT_GT(mean_difference(plain, textured), 0.004);
    }
  }
}

TEST(VolumeMarch, MipLevelsKeepTheMean) {
  std::vector<Vec3f> colors;
  for (std::uint64_t i = 0; i < 9 * 6 * 5; ++i) {
    Random r(1, 2, i);
    colors.push_back(Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform())));
  }
  const SolidTexture t(Vec3i(9, 6, 5), 0.5f, colors);
  ASSERT_EQ(t.levels.size(), 4u);
  EXPECT_EQ(t.levels[1].size, Vec3i(4, 3, 2));
  for (const auto& level : t.levels) {
    double sum = 0;
    for (const auto& x : level.texels) sum += x[0] / 65535.0;
    EXPECT_NEAR(sum / double(level.texels.size()), t.mean.x(), 1e-4);
  }
}

// A texel of the placed texture has the given size whatever the rotation, and the mip level depends on the
// pixel size.
TEST(VolumeMarch, PlacementsHaveTheirScale) {
  const SolidTexture t(Vec3i(16, 16, 16), 0.5f, std::vector<Vec3f>(4096, Vec3f::Constant(0.5f)));
  for (std::uint64_t item = 0; item < 6; ++item) {
    const Placement p = placement(t, 4, 0.1, Turning::Random, 3, item);
    EXPECT_EQ(p.level, 0);
    EXPECT_NEAR((p.linear * p.linear.transpose() - Eigen::Matrix3f::Identity() / 4).norm(), 0, 1e-5);
    EXPECT_EQ(placement(t, 4, 8, Turning::Random, 3, item).level, 2);
    const Placement z = placement(t, 1, 0.1, Turning::AboutZ, 3, item);
    EXPECT_LT((z.linear.col(2) - Vec3f(0, 0, 2)).norm(), 1e-5);
  }
  EXPECT_NE(placement(t, 1, 1, Turning::Random, 3, 1).linear,
            placement(t, 1, 1, Turning::Random, 3, 2).linear);
}

// Equation 7 brightens colors by 1 + int − threshold; the paper exempts skin.
TEST(VolumeMarch, DensityBrightensAllButNoise) {
  const int n = 24;
  const ScanField scan =  // air behind a slab
      field(Vec3i(n, n, n), Vec3::Ones(), [](const Vec3& p) { return p.z() < 1 ? -1000 : 100; });
  Look l = small();
  l.window = Vec2(-1000, 1000);
  const auto mean = [&](const char* tissue, double modulation) {
    l.modulation = modulation;
    double sum = 0;
    for (const auto& c : picture(Scene(scan, parse_tissues({tissue}), {}, l))) sum += c.sum();
    return sum;
  };
  // int − threshold = (100 − (−300)) / 2000, a little less at the faces.
  const char *plain = "meat -300 150 #808080 opacity=0.5", *noise = "skin -300 150 #808080 noise opacity=0.5";
  EXPECT_NEAR(mean(plain, 1) / mean(plain, 0), 1.2, 4e-3);
  EXPECT_NEAR(mean(plain, 0.5) / mean(plain, 0), 1.1, 4e-3);
  ASSERT_GT(mean(noise, 0), 0);
  EXPECT_EQ(mean(noise, 1), mean(noise, 0));
}

TEST(VolumeMarch, TheSameBitsOnAnyNumberOfThreads) {
  Look l = small();
  const Scene scene(ball(32, 11),
                    parse_tissues({"skin -600 -190 #d9a58c noise", "meat -190 150 #8f3a36 texture"}),
                    {SolidTexture(Vec3i(8, 8, 8), 1, stripes(8))}, l);
  const Bricks bricks(scene.scan, scene.intervals);
  const Frame f = frame_of(scene, 10);
  std::vector<std::vector<Vec3f>> pictures;
  for (const int threads : {1, 3, 7}) {
    FrameCounts c;
    tbb::task_arena(threads).execute([&] { pictures.push_back(march(scene, f, bricks, c)); });
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_EQ(pictures[0], pictures[2]);
}

TEST(VolumeMarch, SimplexNoiseIsSmoothAndAboutZero) {
  double sum = 0, squares = 0;
  float most = 0;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    Random r(5, 5, i);
    const Vec3f p(float(r.uniform(-40, 40)), float(r.uniform(-40, 40)), float(r.uniform(-40, 40)));
    const float v = simplex(7, p);
    ASSERT_LT(std::abs(simplex(7, p + Vec3f(1e-3f, -1e-3f, 1e-3f)) - v), 0.02f);
    sum += v;
    squares += v * v;
    most = std::max(most, std::abs(v));
  }
  EXPECT_NEAR(sum / 20000, 0, 0.01);
  EXPECT_GT(std::sqrt(squares / 20000), 0.2);
  EXPECT_LE(most, 1.0f);
}

}  // namespace
}  // namespace terrazzo::render_volume

#include "nodes/color/colorize/colorize.h"

#include "nodes/color/colorize/colors_of_sizes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/texture/color.h"
#include "nodes/common/texture/kmeans.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace colorize;

using test::code_of;

Profile profile(double size, Vec3f color, double weight = 1, int cls = 0) {
  Profile p;
  p.area = std::numbers::pi * size * size / 4;
  p.color = color;
  p.weight = weight;
  p.cls = cls;
  return p;
}

Particles particles(std::size_t n, double size = 1, int cls = 0) {
  Particles p;
  p.box = Vec3::Constant(10);
  p.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    p.size[i] = size;
    p.cls[i] = cls;
  }
  return p;
}

TEST(Colorize, RandomDrawsByWeightAndNeverABorderProfile) {
  Profiles seen;
  seen.binder_color = Vec3f(0.1f, 0.2f, 0.3f);
  seen.profiles = {profile(1, {1, 0, 0}, 1), profile(5, {0, 1, 0}, 3), profile(2, {0, 0, 1}, 0)};
  Particles p = particles(20000);
  colorize::colorize(p, seen, {ColorMode::Random, 7});
  std::map<int, double> count;
  for (const auto& c : p.color) ++count[c.x() == 1 ? 0 : c.y() == 1 ? 1 : 2];
  EXPECT_NEAR(count[0] / 20000, 0.25, 0.015);
  EXPECT_NEAR(count[1] / 20000, 0.75, 0.015);
  EXPECT_EQ(count[2], 0);
  EXPECT_EQ(p.binder_color, seen.binder_color);
}

// Fragments are a quarter of the area; one of them is too small for the particles.
TEST(Colorize, FragmentsGiveTheirShareOfColors) {
  Profiles seen;
  seen.profiles = {profile(2, {1, 0, 0}, 1)};
  const double area = seen.profiles[0].area;
  seen.fragments = {{{0, 1, 0}, area / 4}, {{0, 0, 1}, area / 12}};
  for (const ColorMode mode : {ColorMode::Random, ColorMode::BySize}) {
    Particles p = particles(20000, 2);
    const ColorReport report = colorize::colorize(p, seen, {mode, 7});
    EXPECT_NEAR(report.hidden, 0.25, 1e-12);
    double count[3] = {0, 0, 0};
    for (const auto& c : p.color) ++count[c.x() == 1 ? 0 : c.y() == 1 ? 1 : 2];
    EXPECT_NEAR(count[1] / 20000, 0.25 * 0.75, 0.01);
    EXPECT_EQ(count[2], 0);  // 0.29 as wide
  }
  seen.fragments[0].color[0] = NAN;
  EXPECT_EQ(code_of([&] {
              Particles p = particles(3, 2);
              colorize::colorize(p, seen, {ColorMode::Random, 7});
            }),
            "bad-profile");
}

// Between loose stones: a hidden one, a small one as dark as the gaps, and fragments give no colors.
TEST(Colorize, StonesInTheShadowGiveNoColors) {
  Profiles seen;
  seen.view = View::Surface;
  seen.binder_color = Vec3f::Constant(0.1f);
  seen.profiles = {profile(2, {1, 1, 0}), profile(3, {0.9f, 1, 0}), profile(2, {0, 1, 0}),
                   profile(1, Vec3f::Constant(0.05f)), profile(4, Vec3f::Constant(0.04f))};
  for (Profile& p : seen.profiles) p.whole = p.area;
  seen.profiles[2].whole *= 3;
  seen.fragments = {{{0, 0, 1}, seen.profiles[0].area}};
  Particles p = particles(20000, 2);
  colorize::colorize(p, seen, {ColorMode::Random, 7});
  std::map<float, double> count;
  for (const auto& c : p.color) ++count[c.x()];
  ASSERT_EQ(count.size(), 3u);
  for (const float red : {1.0f, 0.9f, 0.04f}) EXPECT_NEAR(count[red] / 20000, 1 / 3.0, 0.015) << red;
  // A class of dark stones keeps them.
  seen.classes = 2;
  seen.profiles[3].cls = 1;
  p.cls.assign(p.count(), 1);
  colorize::colorize(p, seen, {ColorMode::BySize, 7});
  EXPECT_EQ(p.color[0], Vec3f::Constant(0.05f));
  p.cls.assign(p.count(), 0);
  seen.classes = 1;
  seen.profiles = {seen.profiles[2]};  // better than none
  colorize::colorize(p, seen, {ColorMode::Random, 7});
  EXPECT_EQ(p.color[0], Vec3f(0, 1, 0));
}

TEST(Colorize, BySizeDrawsFromTheParticlesClass) {
  Profiles seen;
  seen.classes = 2;
  seen.profiles = {profile(1, {1, 0, 0}, 1, 0), profile(1, {0, 1, 0}, 1, 1), profile(5, {0, 0, 1}, 1, 1)};
  Particles p = particles(300, 1, 0);
  for (std::size_t i = 0; i < 100; ++i) p.cls[i] = 1;
  for (std::size_t i = 50; i < 100; ++i) p.size[i] = 5.1;
  colorize::colorize(p, seen, {ColorMode::BySize, 3});
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_EQ(p.color[i].x(), i < 100 ? 0 : 1) << i;
    if (i < 50) {
      EXPECT_EQ(p.color[i].y(), 1) << i;  // the other profile of class 1 is larger
    }
  }
  p.cls[7] = 2;
  EXPECT_EQ(code_of([&] { colorize::colorize(p, seen, {ColorMode::BySize, 3}); }), "no-class");
  seen.classes = 1;  // profiles without classes color every particle
  for (Profile& q : seen.profiles) q.cls = 0;
  colorize::colorize(p, seen, {ColorMode::BySize, 3});
}

TEST(Colorize, SectionsOfASphereHaveTheirClosedFormLikelihood) {
  double total = 0, mean = 0;  // bins of 0.1 of the diameter tile [0, 1]
  for (int i = 0; i < 10; ++i) {
    const double p = profile_likelihood(0.1 * i + 0.05, 1);
    total += p;
    mean += p * (0.1 * i + 0.05);
  }
  EXPECT_NEAR(total, 1, 1e-12);
  EXPECT_NEAR(mean, std::numbers::pi / 4, 0.02);  // E[diameter] = πD/4
  EXPECT_EQ(profile_likelihood(1.06, 1), 0);
}

TEST(Colorize, BySizeNeverTakesAProfileThatCannotCome) {
  Profiles seen;  // red up to 1 mm, blue above
  for (int i = 1; i <= 100; ++i)
    seen.profiles.push_back(profile(0.02 * i, i <= 50 ? Vec3f(1, 0, 0) : Vec3f(0, 0, 1)));
  Particles small = particles(2000, 0.9), large = particles(2000, 2), tiny = particles(50, 1e-3);
  for (Particles* p : {&small, &large, &tiny}) colorize::colorize(*p, seen, {ColorMode::BySize, 3});
  for (const auto& c : small.color) ASSERT_EQ(c, Vec3f(1, 0, 0));
  for (const auto& c : tiny.color) ASSERT_EQ(c, Vec3f(1, 0, 0));
  double blue = 0;
  for (const auto& c : large.color) blue += c.z() / 2000;
  EXPECT_NEAR(blue, 0.5, 0.04);  // all profiles come from particles of this size
}

TEST(Colorize, BySizeGivesEachSizeItsColorBack) {
  // A plane through blue spheres of 10 mm and forty times as many red ones of 2 mm, which it meets in
  // proportion to their size.
  Random random(1, 2, 3);
  Profiles seen;
  for (int k = 0; k < 900; ++k) {
    const bool large = k % 9 == 0;
    const double size = large ? 10 : 2, depth = random.uniform(-1, 1);
    seen.profiles.push_back(
        profile(size * std::sqrt(1 - depth * depth), large ? Vec3f(0, 0, 1) : Vec3f(1, 0, 0)));
  }
  Particles p = particles(4100, 2);
  for (std::size_t i = 0; i < 100; ++i) p.size[i] = 10;
  colorize::colorize(p, seen, {ColorMode::BySize, 3});
  double large = 0, small = 0;
  for (std::size_t i = 0; i < p.count(); ++i) (i < 100 ? large : small) += p.color[i].z();
  EXPECT_GT(large / 100, 0.93);  // 0.69 if the likelihood alone were the weight
  EXPECT_LT(small / 4000, 0.02);
}

// A small profile may be the cap of a large particle, but no large profile is blue, so the large particles
// are not.
TEST(Colorize, BySizeKeepsAColorThatOnlySmallProfilesHaveFromLargeParticles) {
  Random random(4, 5, 6);
  Profiles seen;
  for (int k = 0; k < 120; ++k) {
    const double gray = 0.2 + 0.1 * random.uniform(), depth = random.uniform(-1, 1);
    seen.profiles.push_back(
        profile(10 * std::sqrt(1 - depth * depth), Vec3f::Constant(static_cast<float>(gray))));
  }
  for (int k = 0; k < 8; ++k) seen.profiles.push_back(profile(1.2 + 0.05 * k, Vec3f(0.1f, 0.2f, 0.6f)));
  Particles p = particles(1060, 10);
  for (std::size_t i = 0; i < 60; ++i) p.size[i] = 1.7;
  colorize::colorize(p, seen, {ColorMode::BySize, 3});
  int large = 0, small = 0;
  for (std::size_t i = 0; i < p.count(); ++i) (i < 60 ? small : large) += p.color[i].z() > 0.5f;
  EXPECT_LE(large, 5);  // of 1,000; 30 if any particle large enough could have the color
  EXPECT_GE(small, 50);
}

TEST(Colorize, ClassesTakeTheirOwnProfiles) {
  Profiles seen;
  seen.classes = 2;
  seen.profiles = {profile(1, {1, 0, 0}, 1, 0), profile(1, {0, 1, 0}, 1, 1), profile(1, {0, 0.5, 0}, 1, 1)};
  Particles p = particles(500);
  for (std::size_t i = 0; i < p.count(); ++i) p.cls[i] = static_cast<int>(i % 2);
  colorize::colorize(p, seen, {ColorMode::Classes, 1});
  for (std::size_t i = 0; i < p.count(); ++i) ASSERT_EQ(p.color[i].x() == 1, p.cls[i] == 0);
  p.cls[3] = 2;
  EXPECT_EQ(code_of([&] { colorize::colorize(p, seen, {ColorMode::Classes, 1}); }), "no-class");
}

TEST(Colorize, ClassesAreFoundWhereThereAreNone) {
  const Vec3f centers[3] = {{0.6f, 0.1f, 0.1f}, {0.1f, 0.5f, 0.1f}, {0.1f, 0.1f, 0.6f}};
  Profiles seen;
  for (int i = 0; i < 300; ++i) {
    Random r(5, 0, i);
    Vec3f c = centers[i % 3];
    for (int k = 0; k < 3; ++k) c[k] += static_cast<float>(0.02 * r.normal());
    seen.profiles.push_back(profile(0.5 + i % 3, c.cwiseMax(0.f)));  // each color has its own size
  }
  Particles p = particles(300, 2.6);
  const ColorReport report = colorize::colorize(p, seen, {ColorMode::Classes, 9});
  EXPECT_EQ(report.clusters, 3);
  EXPECT_GT(report.silhouette, 0.7);
  std::map<int, int> of_class;
  for (std::size_t i = 0; i < p.count(); ++i) {
    int nearest = 0;
    for (int k = 1; k < 3; ++k)
      if ((p.color[i] - centers[k]).norm() < (p.color[i] - centers[nearest]).norm()) nearest = k;
    const auto [at, fresh] = of_class.emplace(p.cls[i], nearest);
    ASSERT_EQ(at->second, nearest);
  }
  EXPECT_GE(of_class.size(), 1u);
  EXPECT_EQ(colorize::colorize(p = particles(10), seen, {ColorMode::Classes, 9, 5}).clusters, 5);
}

TEST(Colorize, AShapelessCloudIsOneCluster) {
  std::vector<Vec3> points;
  for (int i = 0; i < 400; ++i) {
    Random r(11, 0, i);
    points.emplace_back(r.normal(), r.normal(), r.normal());
  }
  EXPECT_EQ(kmeans_auto(points, std::vector<double>(400, 1), 8, 1).k, 1);
  const ColorClusters few = kmeans({Vec3::Zero(), Vec3::Zero(), Vec3::Ones()}, {1, 1, 1}, 3, 1);
  EXPECT_EQ(few.k, 2);  // distinct points
}

TEST(Colorize, EqualForAnyNumberOfThreads) {
  Profiles seen;
  for (int i = 0; i < 200; ++i) {
    Random r(2, 0, i);
    const auto u = [&] { return static_cast<float>(r.uniform()); };
    seen.profiles.push_back(profile(r.uniform(0.1, 2), Vec3f(u(), u(), u())));
  }
  Particles p = particles(3000);
  for (std::size_t i = 0; i < p.count(); ++i) p.size[i] = Random(3, 0, i).uniform(0.2, 2);
  for (const char* mode : {"random", "by_size", "classes"}) {
    const auto run = [&](int threads) {
      return test::run_node("Colorize", {{"particles", Value::of(p)}, {"profiles", Value::of(seen)}},
                            {{"mode", mode}}, {}, threads);
    };
    const auto one = run(1), two = run(2);
    EXPECT_EQ(one.output<Particles>("particles").color, two.output<Particles>("particles").color) << mode;
    EXPECT_EQ(one.output<Particles>("particles").cls, two.output<Particles>("particles").cls) << mode;
    EXPECT_EQ(one.metrics.at("profiles_used"), 200);
  }
}

TEST(Colorize, BadInputIsSaid) {
  Particles p = particles(3);
  Profiles none, nan, empty;
  EXPECT_EQ(code_of([&] { colorize::colorize(p, none, {}); }), "no-profiles");
  nan.profiles = {profile(1, {NAN, 0, 0})};
  EXPECT_EQ(code_of([&] { colorize::colorize(p, nan, {}); }), "bad-profile");
  empty.profiles = {profile(0, {1, 0, 0})};
  EXPECT_EQ(code_of([&] { colorize::colorize(p, empty, {}); }), "bad-profile");
  Profiles border;
  border.profiles = {profile(1, {1, 0, 0}, 0)};
  EXPECT_TRUE(colorize::colorize(p, border, {}).weightless);
  p.size[1] = 0;
  EXPECT_EQ(code_of([&] { colorize::colorize(p, border, {}); }), "bad-particle");
  Particles nobody = particles(0);
  EXPECT_EQ(colorize::colorize(nobody, border, {}).profiles_used, 1u);
}

}  // namespace
}  // namespace terrazzo

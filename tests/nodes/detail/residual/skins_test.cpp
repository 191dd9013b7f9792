#include "nodes/detail/residual/skins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/bodies/carving/solid.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using residual::Skins;
using std::numbers::pi;
constexpr float pi_f = std::numbers::pi_v<float>;

// A skin of a round stone of 6 mm at 0.1 mm per pixel whose shade says where it is: red grows to the right,
// green downwards, by 0.01 per pixel from the center.
Detail::Skin chart(int profile, const Vec3f& color) {
  Detail::Skin skin;
  skin.profile = profile;
  skin.width = 80;
  skin.height = 100;
  skin.center = {40, 50};
  skin.corner = {10, 20};
  skin.spread = Eigen::Matrix2f::Identity() * 225;  // radius 30 pixels
  skin.size = 6;
  skin.color = color;
  for (int y = 0; y < skin.height; ++y)
    for (int x = 0; x < skin.width; ++x)
      skin.shade.emplace_back(0.01F * (x + 0.5F - 40), 0.01F * (y + 0.5F - 50), 0);
  return skin;
}

Shapes ball_of_3mm() {
  Mesh mesh = test::sphere_mesh(4);
  for (Vec3& v : mesh.vertices) v *= 6;  // from diameter 1
  return test::one_shape(std::move(mesh));
}

Particles one_particle(const Vec3& at, const Quat& turn, double scale, double size = 6) {
  Particles p;
  p.box = Vec3(100, 100, 100);
  p.resize(1);
  p.position[0] = at;
  p.orientation[0] = turn;
  p.scale[0] = scale;
  p.size[0] = size * scale;
  return p;
}

// Round stones of one gray whose shades differ, by 0.1 from one to the next.
Detail shades(int count) {
  Detail detail;
  detail.pixel_size = 0.1;
  for (int k = 0; k < count; ++k) {
    detail.skins.push_back(chart(k + 1, Vec3f::Constant(0.5F)));
    for (Vec3f& v : detail.skins[k].shade) v = Vec3f::Constant(0.1F * static_cast<float>(k));
  }
  return detail;
}

// Equal particles of that gray in one place.
Particles hundred_particles() {
  Particles p = one_particle(Vec3(50, 50, 50), Quat::Identity(), 1);
  p.resize(100);
  for (int i = 0; i < 100; ++i) {
    p.position[i] = p.position[0];
    p.orientation[i] = p.orientation[0];
    p.scale[i] = 1;
    p.size[i] = 6;
    p.color[i] = Vec3f::Constant(0.5F);
  }
  return p;
}

// Where the chart says a point is, in pixels from the center.
Eigen::Vector2f read(const Skins& skins, const Vec3& mm) {
  const Vec3f usual = Vec3f::Constant(0.5F);
  const Vec3f shade = Detail::skin_shade(skins.at(mm.cast<float>(), 0, usual), usual);
  return Eigen::Vector2f(shade.x(), shade.y()) / 0.01F;
}

void expect_near(const Eigen::Vector2f& a, float x, float y, float tolerance = 0.5F) {
  EXPECT_NEAR(a.x(), x, tolerance);
  EXPECT_NEAR(a.y(), y, tolerance);
}

// The height (1 px / k) · sin(k·x) · sin(k·y), rows y running downwards, whose slopes are lit: the shade is
// the slope toward the light.
Detail lit_waves(const Eigen::Vector2f& light) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.relief = {light, 1e6F};  // no stains
  Detail::Skin skin = chart(4, Vec3f::Constant(0.5F));
  skin.width = skin.height = 80;
  skin.center = {40, 40};
  skin.shade.clear();
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 80; ++x) {
      const float u = 0.1F * pi_f * (x + 0.5F - 40), v = 0.1F * pi_f * (y + 0.5F - 40);
      const float right = std::cos(u) * std::sin(v), up = -std::sin(u) * std::cos(v);
      skin.shade.push_back(Vec3f::Constant(0.2F * (light.x() * right + light.y() * up)));
    }
  detail.skins.push_back(skin);
  return detail;
}

TEST(SkinsOfParticles, ReliefIsLitFromWhereTheLightStands) {
  const Vec3 at(50, 50, 50);
  const Vec3f usual = Vec3f::Constant(0.5F);
  Shapes shapes = ball_of_3mm();
  shapes.shapes[0].traced = {4, Vec2(10 + 4, 20 - 4), 0};  // its own skin is never mirrored
  for (const double from : {0.4, 1.9}) {
    const Detail detail = lit_waves(Eigen::Vector2d(std::cos(from), std::sin(from)).cast<float>());
    for (const double to : {0.4, 2.5, 4.0})
      for (const double turn : {0.0, 0.7}) {
        const Eigen::Rotation2Dd turned(turn);
        const Vec2 light(std::cos(to), std::sin(to));
        const Skins skins(detail, one_particle(at, Quat(Eigen::AngleAxisd(turn, Vec3::UnitZ())), 1), shapes,
                          0.1, light);
        for (const Vec2 mm : {Vec2(0.35, 0.2), Vec2(-0.6, 0.9), Vec2(1.3, -1.1)}) {
          Vec3 point = at;
          point.head<2>() += turned * mm;
          const float shade = Detail::skin_shade(skins.at(point.cast<float>(), 0, usual), usual).x();
          const double u = pi * mm.x(), v = -pi * mm.y();
          const Vec2 slope(std::cos(u) * std::sin(v), -std::sin(u) * std::cos(v));
          EXPECT_NEAR(shade, 0.2 * light.dot(turned * slope), 0.015) << from << " " << to << " " << turn;
        }
      }
  }
}

// A stone with a light and a dark face, whose edge is bright, and with grain.
Detail two_faces(float grain) {
  Detail detail = shades(1);
  Detail::Skin& skin = detail.skins[0];
  Random random(5);
  for (int y = 0; y < skin.height; ++y)
    for (int x = 0; x < skin.width; ++x)
      skin.shade[pixel_at(x, y, skin.width)] = Vec3f::Constant((x == 40  ? 0.9F
                                                                : x < 40 ? 0.3F
                                                                         : -0.3F) +
                                                               grain * static_cast<float>(random.normal()));
  return detail;
}

TEST(SkinsOfParticles, BodiesWithFacesGetTheTextureAlone) {
  constexpr float kGrain = 0.05F;
  const Vec3 at(50, 50, 50);
  const Vec3f usual = Vec3f::Constant(0.5F);
  for (const bool faceted : {false, true}) {
    Shapes shapes = ball_of_3mm();
    shapes.shapes[0].traced = {1, Vec2(10 + 4, 20 - 5), 0, faceted};
    const Skins skins(two_faces(kGrain), one_particle(at, Quat::Identity(), 1), shapes, 0, {});
    double left = 0, right = 0, squares = 0;
    constexpr int kPoints = 30;
    for (int k = 0; k < kPoints; ++k) {
      const auto shade = [&](double pixels) {
        const Vec3 mm = at + Vec3(0.1 * (pixels + 0.5), 0.1 * (k - 14.5), 0);
        return Detail::skin_shade(skins.at(mm.cast<float>(), 0, usual), usual).x();
      };
      left += shade(-12) / kPoints;
      right += shade(12) / kPoints;
      squares += shade(12) * shade(12) / kPoints;
      if (faceted) EXPECT_LT(std::abs(shade(0)), 0.2) << k;
    }
    EXPECT_NEAR(left - right, faceted ? 0 : 0.6, 0.05);
    EXPECT_NEAR(std::sqrt(squares - right * right), kGrain, 0.02);
  }
}

// The grain of a large body is as fine as the skin's: it repeats after two skins, mirrored.
TEST(SkinsOfParticles, TextureOfBodiesWithFacesKeepsItsSize) {
  const Vec3 at(50, 50, 50);
  const Vec3f usual = Vec3f::Constant(0.5F);
  Shapes shapes = ball_of_3mm();
  shapes.shapes[0].traced = {1, Vec2(10 + 4, 20 - 5), 0, true};
  const Skins skins(two_faces(0.05F), one_particle(at, Quat::Identity(), 3), shapes, 0, {});
  const auto shade = [&](double x) {
    return Detail::skin_shade(skins.at((at + Vec3(x, 0.05, 0)).cast<float>(), 0, usual), usual).x();
  };
  double difference = 0;
  for (int k = 0; k < 20; ++k) {
    const double x = 0.1 * (k + 0.5);
    EXPECT_NEAR(shade(x), shade(x - 16), 1e-3) << k;  // 2 · 80 pixels of 0.1 mm
    difference += std::abs(shade(x) - shade(x + 0.1)) / 20;
  }
  EXPECT_GT(difference, 0.03);
}

// A close-up: the median's reach has a limit.
TEST(SkinsOfParticles, FacesOfWideSkinsAreRemoved) {
  Detail detail;
  detail.pixel_size = 0.1;
  Detail::Skin skin = chart(1, Vec3f::Constant(0.5F));
  skin.width = skin.height = 2200;
  skin.center = {1100, 1100};
  skin.spread = Eigen::Matrix2f::Identity() * 500 * 500;
  skin.size = 200;
  skin.shade.assign(pixels_in(2200, 2200), Vec3f::Constant(0.4F));
  detail.skins.push_back(skin);
  Shapes shapes = ball_of_3mm();
  shapes.shapes[0].traced = {1, Vec2(120, -90), 0, true};
  const Skins skins(detail, one_particle(Vec3(50, 50, 50), Quat::Identity(), 1), shapes, 0, {});
  const Vec3f usual = Vec3f::Constant(0.5F);
  EXPECT_NEAR(Detail::skin_shade(skins.at(Vec3f(50, 50, 50), 0, usual), usual).x(), 0, 0.02);
}

// Without relief, light from anywhere shows the same stains.
TEST(SkinsOfParticles, StainsDoNotDependOnTheLight) {
  Detail detail = lit_waves(Eigen::Vector2f::UnitX());
  detail.relief.strength = 0;
  const Particles p = one_particle(Vec3(50, 50, 50), Quat::Identity(), 1);
  const Skins left(detail, p, ball_of_3mm(), 0.1, Vec2(-1, 0));
  const Skins above(detail, p, ball_of_3mm(), 0.1, Vec2(0, 1));
  const Vec3f usual = Vec3f::Constant(0.5F);
  for (const Vec3f& mm : {Vec3f(50.3F, 50.2F, 50), Vec3f(49.4F, 51, 50)})
    EXPECT_EQ(left.at(mm, 0, usual), above.at(mm, 0, usual));
}

// A skin whose pixels alternate is gray on a particle of a quarter of its size, not an accident of sampling.
TEST(SkinsOfParticles, ReducedOnesAreSmoothed) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.skins.push_back(chart(1, Vec3f::Constant(0.5F)));
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 80; ++x)
      detail.skins[0].shade[pixel_at(x, y, 80)] = Vec3f::Constant((x + y) % 2 == 0 ? 0.3F : -0.3F);
  const Particles p = one_particle(Vec3(50, 50, 50), Quat::Identity(), 0.25);
  const Skins skins(detail, p, ball_of_3mm(), 0.1, {});
  const Vec3f usual = Vec3f::Constant(0.5F);
  for (int k = 0; k < 20; ++k)
    EXPECT_NEAR(Detail::skin_shade(skins.at(Vec3f(49.7F + 0.03F * k, 50.1F, 50), 0, usual), usual).x(), 0,
                1e-3);
}

TEST(SkinsOfParticles, TheirOwnStonesSkinTurnsWithThem) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.skins.push_back(chart(4, Vec3f::Constant(0.5F)));
  Shapes shapes = ball_of_3mm();
  shapes.shapes[0].traced = {4, Vec2(10 + 4, 20 - 5), 0};  // at the skin's center
  const Vec3 at(99, 1, 50);
  expect_near(read(Skins(detail, one_particle(at, Quat::Identity(), 1), shapes, 0.1, {}), at + Vec3(1, 2, 0)),
              10, -20);
  // Across the box's border.
  expect_near(read(Skins(detail, one_particle(at, Quat::Identity(), 1), shapes, 0.1, {}), Vec3(0, 99, 50)),
              10, 20);
  const Quat quarter(Eigen::AngleAxisd(pi / 2, Vec3::UnitZ()));
  expect_near(read(Skins(detail, one_particle(at, quarter, 0.7), shapes, 0.1, {}), at + Vec3(0, 1, 0)),
              14.29F, 0);
  // The mesh was turned when it was traced.
  shapes.shapes[0].traced.turn = pi / 2;
  expect_near(read(Skins(detail, one_particle(at, Quat::Identity(), 1), shapes, 0.1, {}), at + Vec3(1, 0, 0)),
              0, -10);
  // A stone of another photograph lies elsewhere: the skin then lies about the particle's center.
  shapes.shapes[0].traced.origin = Vec2(200, 200);
  expect_near(read(Skins(detail, one_particle(at, Quat::Identity(), 1), shapes, 0.1, {}), at), 0, 0);
}

TEST(SkinsOfParticles, OthersStretchASkinOverTheirSilhouette) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.skins.push_back(chart(4, Vec3f::Constant(0.5F)));
  Shapes shapes = ball_of_3mm();
  for (Vec3& v : shapes.shapes[0].mesh.vertices) v.x() *= 2;  // half axes 6, 3 and 3 mm
  const Vec3 at(50, 50, 50);
  const Skins along(detail, one_particle(at, Quat::Identity(), 1), shapes, 0.1, {});
  expect_near(read(along, at + Vec3(6, 0, 0)), 30, 0, 1);
  expect_near(read(along, at + Vec3(0, 3, 0)), 0, -30, 1);
  const Quat quarter(Eigen::AngleAxisd(pi / 2, Vec3::UnitZ()));
  const Skins turned(detail, one_particle(at, quarter, 0.5, 8.5), shapes, 0.1, {});
  expect_near(read(turned, at + Vec3(0, 3, 0)), 0, -30, 1);  // a round one is never turned, only stretched
  expect_near(read(turned, at + Vec3(1.5, 0, 0)), 30, 0, 1);
}

// A stone that is four times as long as wide lies across the photograph, and the particle along y.
TEST(SkinsOfParticles, LongOnesAreTurnedRatherThanStretchedFar) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.skins.push_back(chart(4, Vec3f::Constant(0.5F)));
  detail.skins[0].spread = Eigen::Vector2f(900, 56.25F).asDiagonal();  // half axes 60 and 15 pixels
  Shapes shapes = ball_of_3mm();
  for (Vec3& v : shapes.shapes[0].mesh.vertices) v = Vec3(v.x() / 2, v.y() * 2, v.z());
  const Vec3 at(50, 50, 50);
  const Skins skins(detail, one_particle(at, Quat::Identity(), 1), shapes, 0.1, {});
  const Eigen::Vector2f end = read(skins, at + Vec3(0, 3, 0));
  EXPECT_NEAR(std::abs(end.x()), 30, 1);  // half way to the end, and there it is half way too
  EXPECT_NEAR(end.y(), 0, 1);
  EXPECT_NEAR(std::abs(read(skins, at + Vec3(1.5, 0, 0)).y()), 15, 1);
}

TEST(SkinsOfParticles, ColorAndSizeChoose) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.skins.push_back(chart(1, Vec3f(0.6F, 0.1F, 0.1F)));
  detail.skins.push_back(chart(2, Vec3f(0.1F, 0.1F, 0.6F)));
  for (Vec3f& v : detail.skins[1].shade) v = Vec3f(0, 0, 0.5F);
  Particles p = one_particle(Vec3(50, 50, 50), Quat::Identity(), 1);
  p.color[0] = Vec3f(0.15F, 0.1F, 0.55F);
  const Skins skins(detail, p, ball_of_3mm(), 0.1, {});
  EXPECT_NEAR(Detail::skin_shade(skins.at(Vec3f::Constant(50), 0, p.color[0]), p.color[0]).z(), 0.5, 1e-3);
  EXPECT_FALSE(
      Skins(detail, one_particle(Vec3::Zero(), Quat::Identity(), 0.3), ball_of_3mm(), 0.1, {}).bare(0));
  EXPECT_TRUE(Skins(Detail(), p, ball_of_3mm(), 0.1, {}).bare(0));
}

TEST(SkinsOfParticles, AllSkinsCoverAboutAsMuch) {
  const Detail detail = shades(5);
  const Particles p = hundred_particles();
  const Skins skins(detail, p, ball_of_3mm(), 0.1, {});
  std::vector<int> worn(5, 0);
  for (int i = 0; i < 100; ++i) {
    const Vec3f shade = Detail::skin_shade(skins.at(Vec3f::Constant(50), i, p.color[i]), p.color[i]);
    ++worn.at(std::lround(shade.x() / 0.1F));
    EXPECT_NEAR(skins.lost_grain(i), 0, 1e-5);
  }
  for (const int n : worn) EXPECT_NEAR(n, 20, 8);
}

TEST(SkinsOfParticles, HalfOfThemAreMirroredAndNoneIsUpsideDown) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.skins.push_back(chart(1, Vec3f::Constant(0.5F)));
  const Particles p = hundred_particles();
  const Skins skins(detail, p, ball_of_3mm(), 0.1, {});
  int mirrored = 0;
  for (int i = 0; i < 100; ++i) {
    const Vec3f usual = Vec3f::Constant(0.5F);
    const Vec3f shade = Detail::skin_shade(skins.at(Vec3f(51, 52, 50), i, usual), usual);
    EXPECT_NEAR(std::abs(shade.x()), 0.1, 0.005);
    EXPECT_NEAR(shade.y(), -0.2, 0.005);
    mirrored += shade.x() < 0;
  }
  EXPECT_NEAR(mirrored, 50, 15);
}

TEST(SkinsOfParticles, PreferStonesThatNothingHides) {
  Detail detail = shades(2);
  detail.skins[0].spread *= 0.7F;
  const Particles p = one_particle(Vec3(50, 50, 50), Quat::Identity(), 1);
  const Vec3f usual = Vec3f::Constant(0.5F);
  const Skins skins(detail, p, ball_of_3mm(), 0.1, {});
  EXPECT_NEAR(Detail::skin_shade(skins.at(Vec3f::Constant(50), 0, usual), usual).x(), 0.1, 1e-3);
}

TEST(SkinsOfParticles, EnlargedOnesLackGrainAndBadOnesAreNotWorn) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.skins.push_back(chart(1, Vec3f::Constant(0.5F)));
  Particles p = one_particle(Vec3(50, 50, 50), Quat::Identity(), 2);
  EXPECT_NEAR(Skins(detail, p, ball_of_3mm(), 0.1, {}).lost_grain(0), 1, 0.01);
  p.color[0] = Vec3f::Constant(std::nanf(""));
  EXPECT_TRUE(Skins(detail, p, ball_of_3mm(), 0.1, {}).bare(0));
}

TEST(SkinsOfParticles, TheGroundRepeatsWithItsPicture) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.ground.width = 20;
  detail.ground.height = 30;
  for (int i = 0; i < 600; ++i)
    detail.ground.shade.push_back(Vec3f::Constant(static_cast<float>(Random(1, 2, i).uniform())));
  const Skins skins(detail, one_particle(Vec3::Zero(), Quat::Identity(), 1), ball_of_3mm(), 0.1, {});
  ASSERT_TRUE(skins.has_ground());
  const Vec3f usual = Vec3f::Constant(0.4F);
  const auto at = [&](float x, float y) {
    return Detail::skin_shade(skins.ground(Vec3f(x, y, 7), usual), usual).x();
  };
  EXPECT_NEAR(at(0.55F, -0.35F), detail.ground.shade[3 * 20 + 5].x(), 1e-3);
  EXPECT_NEAR(at(0.55F + 2, -0.35F + 3), detail.ground.shade[3 * 20 + 5].x(), 2e-3);
  EXPECT_FALSE(
      Skins(Detail(), one_particle(Vec3::Zero(), Quat::Identity(), 1), ball_of_3mm(), 0.1, {}).has_ground());
}

TEST(SkinsOfParticles, AHeapOfStonesWearsThem) {
  Detail detail;
  detail.pixel_size = 0.1;
  detail.skins.push_back(chart(4, Vec3f::Constant(0.5F)));
  Shapes shapes = ball_of_3mm();
  shapes.shapes[0].traced = {4, Vec2(10 + 4, 20 - 5), 0};
  Particles p = one_particle(Vec3(50, 50, 2), Quat(Eigen::AngleAxisd(0.7, Vec3::UnitX())), 1);
  p.color[0] = Vec3f(0.4F, 0.3F, 0.2F);
  const Skins skins(detail, p, shapes, 0, {});
  ASSERT_FALSE(skins.bare(0));
  const auto heap = carving::particle_solid(p, shapes, nullptr, &skins);
  for (std::uint64_t k = 0; k < 50; ++k) {
    Random r(5, 5, k);
    const Vec3f from(static_cast<float>(r.uniform(0.485, 0.515)), static_cast<float>(r.uniform(0.485, 0.515)),
                     1);
    carving::SurfacePoint s;
    ASSERT_TRUE(heap->nearest(from, Vec3f(0, 0, -1), s, true));
    const Vec3f mm = 100 * s.position - Vec3f(0, 0, 1);  // the lowest point lies on the floor
    EXPECT_LT((s.albedo - skins.at(mm, 0, p.color[0])).norm(), 2e-3F);
    EXPECT_GT((s.albedo - p.color[0]).norm(), 1e-3F);
  }
}

TEST(SkinsOfParticles, WithoutLightOnlyTheHueOfBroadDetailStays) {
  Detail detail;
  detail.skins.push_back(chart(4, Vec3f::Constant(0.5F)));
  detail.phases.resize(2);
  detail.phases[1].slope = 0.2F;
  detail.phases[1].tile = {Vec3f(0.1F, 0.2F, 0.3F)};
  detail.phases[1].broad = {Vec3f(0.1F, 0.2F, 0.6F), Vec3f(-0.3F, 0, 0)};
  const Detail left = residual::without_light(detail);
  EXPECT_TRUE(left.skins.empty());
  EXPECT_EQ(left.phases[1].slope, 0);
  EXPECT_EQ(left.phases[1].tile, detail.phases[1].tile);
  EXPECT_LT((left.phases[1].broad[0] - Vec3f(-0.2F, -0.1F, 0.3F)).norm(), 1e-6F);
  EXPECT_LT((left.phases[1].broad[1] - Vec3f(-0.2F, 0.1F, 0.1F)).norm(), 1e-6F);
}

}  // namespace
}  // namespace terrazzo

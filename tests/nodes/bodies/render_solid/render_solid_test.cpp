#include <gtest/gtest.h>

#include <cmath>

#include "nodes/bodies/carving/color_field.h"
#include "nodes/bodies/carving/paint.h"
#include "nodes/bodies/render_solid/render.h"
#include "nodes/bodies/render_solid/sampler.h"
#include "nodes/bodies/render_solid/tone.h"
#include "nodes/data/profiles.h"
#include "nodes/data/volume.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace carving;
using namespace render_solid;
using test::run_node;

ColorField uniform_field(const Vec3f& color) {
  return ColorField(Vec3i(4, 4, 4), std::vector<Vec3f>(64, color));
}

// Red, green and blue encode x, y and z.
ColorField coordinate_field(int n) {
  std::vector<Vec3f> c;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        c.push_back((Vec3f(float(x), float(y), float(z)).array() + 0.5f) / float(n));
  return ColorField(Vec3i(n, n, n), c);
}

Volume volume_of(int n, const Vec3f& color) {
  initialize_openvdb();
  Volume v;
  v.resolution = Vec3i(n, n, n);
  auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  grid->setName("Cd");
  grid->setTransform(voxel_transform(0.5));
  grid->denseFill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(n - 1)),
                  openvdb::Vec3s(color.x(), color.y(), color.z()));
  v.grids.push_back(grid);
  return v;
}

Shape sphere(int rings) {
  Shape s;
  s.name = "ball";
  s.smooth = true;
  const int turns = 2 * rings;
  s.mesh.vertices.push_back(Vec3(0, 0, 1));
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < turns; ++j) {
      const double a = M_PI * i / rings, b = 2 * M_PI * j / turns;
      s.mesh.vertices.push_back(Vec3(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)));
    }
  s.mesh.vertices.push_back(Vec3(0, 0, -1));
  const int last = static_cast<int>(s.mesh.vertices.size()) - 1;
  for (int j = 0; j < turns; ++j) {
    const int k = (j + 1) % turns;
    s.mesh.triangles.push_back({0, 1 + j, 1 + k});
    s.mesh.triangles.push_back({last, last - turns + k, last - turns + j});
    for (int i = 0; i + 2 < rings; ++i) {
      const int a = 1 + i * turns;
      s.mesh.triangles.push_back({a + j, a + turns + j, a + turns + k});
      s.mesh.triangles.push_back({a + j, a + turns + k, a + k});
    }
  }
  return s;
}

// A solid and the paint it refers to.
struct Painted {
  std::unique_ptr<Paint> paint;
  std::unique_ptr<Solid> solid;
  const Solid& operator*() const { return *solid; }
  const Solid* operator->() const { return solid.get(); }
};
Painted block(const ColorField& field, double repeat = 1, double cut = 0.5, double bevel = 0.008) {
  Painted p{field_paint(field, repeat), nullptr};
  p.solid = block_solid(*p.paint, cut, bevel);
  return p;
}
Painted object(const ColorField& field, const Shape& shape) {
  Painted p{field_paint(field, 1, {}, false), nullptr};
  p.solid = object_solid(*p.paint, shape);
  return p;
}

RenderOptions plain(int size, int samples) {
  RenderOptions s;
  s.width = s.height = size;
  s.samples = samples;
  s.gloss = 0;
  return s;
}

Vec3f pixel_of(const Image& image, const Camera& camera, const Vec3f& point) {
  const Eigen::Vector2f p = camera.project(point, image.width, image.height);
  return image.at(static_cast<int>(p.x()), static_cast<int>(p.y()));
}

std::string failure(const std::multimap<std::string, Value>& inputs,
                    std::map<std::string, std::string> parameters = {}) {
  parameters.insert({{"width", "16"}, {"height", "16"}, {"samples", "1"}});
  return test::code_of([&] { run_node("RenderSolid", inputs, parameters); });
}

TEST(RenderSolid, AConvexBodyInAFurnaceShowsItsAlbedo) {
  const Vec3f albedo(0.8f, 0.3f, 0.05f);
  const ColorField field = uniform_field(albedo);
  Painted bodies[] = {block(field, 1, 0), object(field, sphere(12))};
  for (const Painted& solid : bodies) {
    const Camera camera = Camera::framing(solid->bounds(), -0.7f, 0.5f, 48, 48);
    const Image image = render(*solid, Studio::furnace(), camera, plain(48, 4));
    EXPECT_LT((image.at(24, 24) - albedo).norm(), 1e-4);
    EXPECT_LT((image.at(30, 28) - albedo).norm(), 1e-4);
    EXPECT_EQ(image.at(0, 0), Vec3f(Vec3f::Ones()));  // the furnace itself
  }
}

TEST(RenderSolid, PicturesThatAreRefinedEndInTheSameBits) {
  const ColorField field = uniform_field(Vec3f(0.8f, 0.3f, 0.05f));
  const auto solid = block(field, 1, 0.5);
  const Camera camera = Camera::framing(solid->bounds(), -0.7f, 0.5f, 40, 30);
  for (const int samples : {1, 2, 11, 16}) {
    RenderOptions settings = plain(40, samples);
    settings.height = 30;
    settings.gloss = 0.4f;
    std::vector<Image> shown;
    const Image refined = render(*solid, Studio({}), camera, settings, {},
                                 [&](Image image) { shown.push_back(std::move(image)); }),
                whole = render(*solid, Studio({}), camera, settings);
    EXPECT_EQ(refined.pixels, whole.pixels);
    EXPECT_EQ(shown.size(), samples <= 2 ? 0u : samples == 11 ? 4u : 2u);  // 1, 1, 11, 4 rays
    for (const Image& image : shown) {
      Vec3f sum = Vec3f::Zero();
      for (std::size_t i = 0; i < image.pixels.size(); ++i) sum += image.pixels[i] - whole.pixels[i];
      EXPECT_LT(sum.norm() / static_cast<float>(image.pixels.size()), 0.02f);
    }
  }
}

TEST(RenderSolid, AWhiteBodyVanishesInAFurnace) {
  const ColorField field = uniform_field(Vec3f::Ones());
  const auto solid = block(field, 1, 0.5);  // concave: light bounces inside
  const Camera camera = Camera::framing(solid->bounds(), -0.7f, 0.5f, 40, 40);
  const Image image = render(*solid, Studio::furnace(), camera, plain(40, 4));
  for (const Vec3f& p : image.pixels) ASSERT_LT((p - Vec3f::Ones()).cwiseAbs().maxCoeff(), 1e-4);
}

// A gray concavity loses light to itself: it is darker than its albedo, yet brighter than without a second
// bounce.
TEST(RenderSolid, InnerFacesShadeEachOther) {
  const ColorField field = uniform_field(Vec3f::Constant(0.5f));
  const auto solid = block(field, 1, 0.5, 0);
  const Camera camera = Camera::framing(solid->bounds(), -0.7f, 0.5f, 120, 120);
  const Image image = render(*solid, Studio::furnace(), camera, plain(120, 64));
  const Vec3f deep = pixel_of(image, camera, Vec3f(0.56f, 0.44f, 0.5f));
  EXPECT_LT(deep.x(), 0.4f);
  EXPECT_GT(deep.x(), 0.2f);
  EXPECT_NEAR(pixel_of(image, camera, Vec3f(0.25f, 0.75f, 1)).x(), 0.5f, 1e-4);
}

TEST(RenderSolid, FacesShowTheVoxelsBelowThem) {
  const int n = 32;
  const ColorField field = coordinate_field(n);
  const auto solid = block(field, 1, 0.5, 0);
  const int size = 200;
  const Camera camera = Camera::framing(solid->bounds(), -0.7f, 0.5f, size, size);
  const Image image = render(*solid, Studio::furnace(), camera, plain(size, 16));
  const float half = 0.5f / n;
  struct Expected {
    Vec3f point, color;
  };
  // On outer faces the color is the albedo itself.
  const std::vector<Expected> outer = {
      {{0.25f, 0.8f, 1}, {0.25f, 0.8f, 1 - half}},  // top
      {{1, 0.75f, 0.4f}, {1 - half, 0.75f, 0.4f}},  // right
      {{0.3f, 0, 0.4f}, {0.3f, half, 0.4f}},        // left
      {{1, 0.2f, 0.2f}, {1 - half, 0.2f, 0.2f}},    // below the cut
  };
  for (const auto& [point, color] : outer)
    EXPECT_LT((pixel_of(image, camera, point) - color).norm(), 0.02f) << point.transpose();
  // Inside, faces reflect each other; without bounces the color is the albedo again.
  RenderOptions direct = plain(size, 16);
  direct.bounces = 0;
  const Image inner = render(*solid, Studio::furnace(), camera, direct);
  const std::vector<Expected> inside = {
      {{0.5f, 0.3f, 0.7f}, {0.5f - half, 0.3f, 0.7f}},
      {{0.7f, 0.5f, 0.75f}, {0.7f, 0.5f + half, 0.75f}},
      {{0.75f, 0.25f, 0.5f}, {0.75f, 0.25f, 0.5f - half}},
  };
  for (const auto& [point, color] : inside)
    EXPECT_LT((pixel_of(inner, camera, point) - color).norm(), 0.02f) << point.transpose();
}

TEST(RenderSolid, RepeatTilesTheVolume) {
  const ColorField field = coordinate_field(16);
  const auto solid = block(field, 2, 0, 0);
  const Camera camera = Camera::framing(solid->bounds(), -0.7f, 0.5f, 160, 160);
  const Image image = render(*solid, Studio::furnace(), camera, plain(160, 16));
  const Vec3f a = pixel_of(image, camera, Vec3f(0.2f, 0.3f, 1)),
              b = pixel_of(image, camera, Vec3f(0.7f, 0.8f, 1));
  EXPECT_LT((a - b).norm(), 0.04f);
  EXPECT_NEAR(a.x(), 0.4f, 0.03f);
}

// In the studio: neutral light keeps a color's ratios, and a white top is about 1.
TEST(RenderSolid, LightIsNeutralAndWhiteIsWhite) {
  const ColorField gray = uniform_field(Vec3f::Constant(0.5f)), white = uniform_field(Vec3f::Ones());
  const Studio studio({});
  EXPECT_NEAR(studio.irradiance(Vec3f::UnitZ()), 1, 0.01);
  const auto a = block(gray), b = block(white);
  const Camera camera = Camera::framing(a->bounds(), -0.7f, 0.5f, 64, 64);
  const Image dark = render(*a, studio, camera, plain(64, 8)),
              light = render(*b, studio, camera, plain(64, 8));
  for (const Vec3f& p : dark.pixels) ASSERT_LT(p.maxCoeff() - p.minCoeff(), 1e-5);
  const Vec3f top(0.25f, 0.8f, 1);
  EXPECT_NEAR(pixel_of(dark, camera, top).x(), 0.5f, 0.02f);
  EXPECT_NEAR(pixel_of(light, camera, top).x(), 1.0f, 0.03f);
}

// The closed forms of the studio compared with sampling its light.
TEST(RenderSolid, TheStudiosIrradianceIsTheIntegralOfItsLight) {
  const Studio studio({});
  for (const Vec3f& normal :
       {Vec3f(0, 0, 1), Vec3f(1, 0, 0), Vec3f(0, -1, 0), Vec3f(Vec3f(0.3f, -0.5f, 0.4f).normalized())}) {
    PixelSampler random(3, 1, 1u << 14);
    double dome = 0, lamp = 0;
    for (std::uint32_t i = 0; i < (1u << 14); ++i) {
      random.start(i);
      float u, v;
      random.next(u, v);
      dome += studio.radiance(cosine_direction(normal, u, v));
      random.next(u, v);
      lamp += studio.lamp() * std::max(0.0f, normal.dot(studio.to_lamp(u, v)));
    }
    EXPECT_NEAR((dome + lamp) / (1 << 14), studio.irradiance(normal), 0.004);
  }
}

TEST(RenderSolid, TheBlockShadowsTheFloorBesideIt) {
  const ColorField field = uniform_field(Vec3f::Constant(0.2f));
  const auto solid = block(field, 1, 0);
  const Camera camera = Camera::framing(solid->bounds(), -0.7f, 0.5f, 96, 96, 0.38f, 0.5f);
  const Studio studio({});
  const Image image = render(*solid, studio, camera, plain(96, 32));
  const float open = studio.settings().background;
  EXPECT_NEAR(image.at(2, 2).x(), open, 0.02f);
  EXPECT_LT(pixel_of(image, camera, Vec3f(1.05f, 0.6f, 0)).x(), 0.75f * open);
}

TEST(RenderSolid, ToneCurveKeepsMidtonesAndHues) {
  EXPECT_EQ(neutral_curve(Vec3f(0.2f, 0.5f, 0.8f)), Vec3f(0.2f, 0.5f, 0.8f));
  const Vec3f bright = neutral_curve(Vec3f(2, 1, 0.5f));
  EXPECT_LE(bright.maxCoeff(), 1);
  EXPECT_NEAR(bright.x() / bright.y(), 2, 1e-5);
  float before = 0;
  for (float v = 0; v < 3; v += 0.01f) {
    const float now = neutral_curve(Vec3f::Constant(v)).x();
    EXPECT_GE(now, before - 1e-6f);
    before = now;
  }
}

TEST(RenderSolid, PairsOfThePixelSamplerAreStratified) {
  for (std::uint64_t pixel = 0; pixel < 20; ++pixel) {
    PixelSampler random(1, pixel, 16);
    std::vector<std::vector<int>> cells(5, std::vector<int>(16));
    for (std::uint32_t i = 0; i < 16; ++i) {
      random.start(i);
      for (auto& c : cells) {
        float u, v;
        random.next(u, v);
        ASSERT_GE(u, 0);
        ASSERT_LT(u, 1);
        ASSERT_LT(v, 1);
        ++c[static_cast<std::size_t>(u * 4) * 4 + static_cast<std::size_t>(v * 4)];
      }
    }
    for (const auto& c : cells)
      for (const int n : c) EXPECT_EQ(n, 1);  // one in each of 4 × 4 cells
  }
}

TEST(RenderSolid, CatmullRomPassesThroughTheVoxels) {
  std::vector<Vec3f> colors;
  for (std::size_t i = 0; i < 125; ++i) {
    Random r(4, 4, i);
    colors.push_back(Vec3f(float(r.uniform()), float(r.uniform()), float(r.uniform())));
  }
  const ColorField field(Vec3i(5, 5, 5), colors);
  for (int i = 0; i < 125; ++i) {
    const Vec3f p = Vec3f(float(i % 5), float(i / 5 % 5), float(i / 25)).array() + 0.5f;
    EXPECT_LT((field.sharp(p) - colors[i]).norm(), 1e-3);
    EXPECT_LT((field.at(p) - colors[i]).norm(), 1e-3);
    EXPECT_LT((field.at(p + Vec3f(5, -10, 5)) - colors[i]).norm(), 1e-3);  // periodic
  }
}

TEST(RenderSolid, TheSamePictureOnAnyNumberOfThreads) {
  Volume volume = volume_of(8, Vec3f(0.5f, 0.3f, 0.2f));
  const std::map<std::string, std::string> p = {{"width", "40"}, {"height", "30"}, {"samples", "4"}};
  std::vector<Image> images;
  for (const int threads : {1, 3})
    images.push_back(
        run_node("RenderSolid", {{"volume", Value::of(volume)}}, p, {}, threads).output<Image>("image"));
  EXPECT_EQ(images[0].pixels, images[1].pixels);
  auto other = p;
  other["seed"] = "2";
  EXPECT_NE(run_node("RenderSolid", {{"volume", Value::of(volume)}}, other).output<Image>("image").pixels,
            images[0].pixels);
}

TEST(RenderSolid, EveryModeShowsItsSolid) {
  const Value volume = Value::of(volume_of(8, Vec3f(0.1f, 0.6f, 0.1f)));
  Shapes ball;
  ball.shapes = {sphere(8)};
  Particles one;
  one.box = Vec3(2, 2, 2);
  one.resize(1);
  one.position[0] = Vec3(1, 1, 1);
  one.color[0] = Vec3f(0.1f, 0.6f, 0.1f);
  const std::multimap<std::string, Value> inputs = {{"volume", volume},
                                                    {"object", Value::of(ball)},
                                                    {"particles", Value::of(one)},
                                                    {"shapes", Value::of(ball)}};
  std::vector<Image> images;
  for (const std::string mode : {"block", "cube", "object", "particles", "auto"}) {
    const auto run =
        run_node("RenderSolid", inputs,
                 {{"mode", mode}, {"width", "48"}, {"height", "32"}, {"samples", "4"}, {"gloss", "0"}});
    images.push_back(run.output<Image>("image"));
    const Vec3f c = images.back().at(24, 16);
    EXPECT_GT(c.y(), 3 * c.x()) << mode;
    const Vec3f corner = images.back().at(0, 0);
    EXPECT_NEAR(corner.x(), 0.82f, 0.03f) << mode;
  }
  EXPECT_NE(images[0].pixels, images[1].pixels);
  EXPECT_EQ(images[2].pixels, images[4].pixels);
  // The ball as a particle in a box of its own size matches the ball as an object, in the same color.
  double difference = 0;
  for (std::size_t i = 0; i < images[2].pixels.size(); ++i)
    difference = std::max<double>(difference, (images[2].pixels[i] - images[3].pixels[i]).norm());
  EXPECT_LT(difference, 0.02);
}

TEST(RenderSolid, AutoShowsWhatThePhotographShows) {
  Shapes ball;
  ball.shapes = {sphere(8)};
  Particles one;
  one.box = Vec3(2, 2, 2);
  one.resize(1);
  one.position[0] = Vec3(1, 1, 1);
  const auto picture = [&](const std::string& mode, const Profiles* photograph, bool object) {
    std::multimap<std::string, Value> inputs = {{"particles", Value::of(one)}, {"shapes", Value::of(ball)}};
    if (photograph) inputs.emplace("profiles", Value::of(*photograph));
    if (object) inputs.emplace("object", Value::of(ball));
    const auto run = run_node("RenderSolid", inputs,
                              {{"mode", mode}, {"width", "24"}, {"height", "16"}, {"samples", "2"}});
    return run.output<Image>("image").pixels;
  };
  Profiles cut, loose;
  cut.area_fraction = loose.area_fraction = 0.9;
  cut.profiles.resize(1);
  loose.profiles.resize(1);
  cut.view = View::Section;
  loose.view = View::Surface;
  ASSERT_TRUE(shows_loose_stones(loose));
  const auto block = picture("block", nullptr, false), stones = picture("particles", nullptr, false);
  ASSERT_NE(block, stones);
  EXPECT_EQ(picture("auto", nullptr, false), stones);
  EXPECT_EQ(picture("auto", &cut, false), block);
  EXPECT_EQ(picture("auto", &loose, false), stones);
  EXPECT_EQ(picture("auto", &cut, true), picture("object", nullptr, true));
  EXPECT_EQ(picture("auto", &loose, true), stones);
}

TEST(RenderSolid, BadInput) {
  EXPECT_EQ(failure({}), "no-volume");
  EXPECT_EQ(failure({{"volume", Value::of(Volume())}}), "no-color");
  const Value good = Value::of(volume_of(4, Vec3f(0.5f, 0.5f, 0.5f)));
  EXPECT_EQ(failure({{"volume", good}}), "");
  EXPECT_EQ(failure({{"volume", good}}, {{"mode", "object"}}), "no-object");
  EXPECT_EQ(failure({{"volume", good}}, {{"mode", "particles"}}), "no-particles");
  EXPECT_EQ(failure({{"volume", good}}, {{"width", "0"}}), "bad-value");
  EXPECT_EQ(failure({{"volume", good}, {"object", Value::of(Shapes())}}), "no-shapes");
  Shapes flat;
  flat.shapes.resize(1);
  EXPECT_EQ(failure({{"volume", good}, {"object", Value::of(flat)}}), "bad-mesh");
  EXPECT_EQ(failure({{"volume", Value::of(volume_of(4, Vec3f(0.5f, NAN, 0.5f)))}}), "bad-colors");
  Volume wrong = volume_of(4, Vec3f::Zero());
  auto scalar = openvdb::FloatGrid::create(1);
  scalar->setName("Cd");
  wrong.grids = {scalar};
  EXPECT_EQ(failure({{"volume", Value::of(wrong)}}), "no-color");
  Volume hollow = volume_of(4, Vec3f::Zero());
  hollow.resolution.setZero();
  auto empty = openvdb::Vec3SGrid::create(openvdb::Vec3s(0));
  empty->setName("Cd");
  hollow.grids = {empty};
  EXPECT_EQ(failure({{"volume", Value::of(hollow)}}), "empty-volume");
  Particles none;
  EXPECT_EQ(failure({{"particles", Value::of(none)}, {"shapes", Value::of(flat)}}), "no-particles");
  // A non-periodic volume is shown over its active voxels.
  Volume open = volume_of(4, Vec3f(0.5f, 0.5f, 0.5f));
  open.resolution.setZero();
  EXPECT_EQ(failure({{"volume", Value::of(open)}}), "");
}

TEST(RenderSolid, WarnsOfColorsThatNoSurfaceHas) {
  const auto run = run_node("RenderSolid", {{"volume", Value::of(volume_of(4, Vec3f(1.5f, 0.5f, 0.5f)))}},
                            {{"width", "8"}, {"height", "8"}, {"samples", "1"}});
  EXPECT_EQ(run.warnings.size(), 1u);
}

}  // namespace
}  // namespace terrazzo

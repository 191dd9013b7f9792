#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/bodies/view/pieces.h"
#include "nodes/bodies/view/surface_view.h"
#include "nodes/data/detail.h"
#include "nodes/detail/residual/residual_field.h"
#include "runtime/random.h"
#include "tests/nodes/bodies/section/packing.h"
#include "tests/nodes/volumes/voxelize/bodies.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace view;

using test::run_node;

Shapes ball() {
  Mesh mesh = test::sphere_mesh(4);
  for (Vec3& v : mesh.vertices) v *= 2;  // radius 1 mm
  Shapes shapes = test::one_shape(std::move(mesh));
  shapes.shapes[0].smooth = true;
  return shapes;
}

struct Sphere {
  Vec3 center;
  double radius;
};

Particles spheres_of(const std::vector<Sphere>& spheres, double box) {
  Particles p;
  p.box = Vec3::Constant(box);
  p.resize(spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    p.position[i] = spheres[i].center;
    p.orientation[i] = Quat::Identity();
    p.scale[i] = spheres[i].radius;
    p.size[i] = 2 * spheres[i].radius;
    p.shape[i] = 0;
    p.cls[i] = i % 2;
    p.color[i] = Vec3f::Constant(0.3f);
  }
  p.binder_color = Vec3f::Constant(0.1f);
  return p;
}

// One whole period from above, cut at the height.
SurfaceOptions whole_box(const Particles& particles, double height, int pixels = 200) {
  SurfaceOptions options;
  options.places = {{height, Vec2::Zero()}};
  options.width = particles.box.x();
  options.height = particles.box.y();
  options.pixels_x = pixels;
  options.pixels_y = pixels;
  options.pixel_size = options.width / pixels;
  options.light = light_of(std::nullopt, std::nullopt, std::nullopt);
  return options;
}

Particles four_spheres() {
  return spheres_of({{{2.5, 7.5, 5}, 1.2}, {{7.5, 7.4, 5}, 0.8}, {{2.5, 2.5, 5}, 1}, {{7.5, 2.4, 5}, 0.6}},
                    10);
}

// A loose bed of spheres and the pieces of their periodic copies.
Particles loose_bed() { return test::apart_particles(3, 4000, 12, 0.4, 1.1, ball().shapes[0]); }

std::vector<double> pixels_of_labels(const SurfaceView& seen) {
  std::vector<double> pixels(seen.labels.count() + 1, 0.0);
  for (const std::int32_t id : seen.labels.ids) ++pixels.at(id);
  return pixels;
}

TEST(View, ShowsOneLayerAsItsDiscs) {
  const Particles p = four_spheres();
  const SurfaceView seen = show_surface(p, ball(), whole_box(p, 9), nullptr);
  ASSERT_EQ(seen.profiles.profiles.size(), 4u);
  ASSERT_EQ(seen.labels.count(), 4);
  EXPECT_EQ(seen.stones, 4);
  const double pixel = seen.image.pixel_size;
  const std::vector<double> pixels = pixels_of_labels(seen);
  double discs = 0;
  for (int k = 0; k < 4; ++k) {  // in reading order, like the spheres
    const Profile& q = seen.profiles.profiles[k];
    const double disc = std::numbers::pi * p.scale[k] * p.scale[k];
    discs += disc;
    EXPECT_NEAR(q.area, disc, 6 * p.scale[k] * pixel * 0.2) << k;
    EXPECT_NEAR(pixels[k + 1] * pixel * pixel, q.area, 1e-9) << k;
    EXPECT_NEAR((q.centroid - p.position[k].head<2>()).norm(), 0, 0.2 * pixel) << k;
    EXPECT_NEAR(loop_area(q.contour), q.area, 0.01 * q.area) << k;
    EXPECT_NEAR(q.whole, q.area, 0.05 * q.area) << k;
    EXPECT_EQ(q.cls, k % 2);
    EXPECT_FALSE(q.touches_border);
    const double places = std::pow(199 - std::round(2 * p.scale[k] / pixel), 2);
    EXPECT_NEAR(q.weight, 200.0 * 200 / places, 0.03) << k;
  }
  EXPECT_NEAR(seen.profiles.area_fraction, discs / 100, 0.002);
  EXPECT_EQ(seen.profiles.view, terrazzo::View::Surface);
  EXPECT_NEAR(seen.profiles.observed_area, 100, 1e-9);
}

TEST(View, HidesWhatLiesBelow) {
  const Particles p = spheres_of({{{5, 5, 6.2}, 1.5}, {{5.3, 5, 0.2}, 0.4}}, 12);
  const SurfaceView above = show_surface(p, ball(), whole_box(p, 10.8), nullptr);
  ASSERT_EQ(above.profiles.profiles.size(), 1u);
  EXPECT_EQ(std::get<double>(above.table.rows[0][1]), 0);
  EXPECT_EQ(above.stones, 1);
  // A cut between them takes the large one away, since more than its height lies between it and the cut; its
  // copy lies one period deeper.
  const SurfaceView below = show_surface(p, ball(), whole_box(p, 0.5), nullptr);
  ASSERT_EQ(below.profiles.profiles.size(), 2u);
  EXPECT_EQ(below.stones, 2);
}

// Stones that fell lie below the top of their box, from which they are seen.
TEST(View, ShowsFallenStonesFromTheTop) {
  const Shapes shapes = ball();
  const auto heights = [&](double lowest) {
    const Particles p = spheres_of({{{5, 5, lowest}, 1}, {{2, 2, 6}, 1}}, 10);
    std::vector<double> out;
    for (const BedPlace& place : choose_places(3, p, shapes, 1)) out.push_back(place.height);
    return out;
  };
  EXPECT_EQ(heights(1.01), (std::vector<double>{10, 10, 10}));
  const std::vector<double> cut = heights(0.9);  // a packing that repeats upwards
  EXPECT_NEAR(cut[1] - cut[0], 10.0 / 3, 1e-9);
  // A stone on the floor, which is the top of the copy below, is not seen again on top. Soil covers none from
  // above.
  double radius = 0;
  for (const Vec3& v : shapes.shapes[0].mesh.vertices) radius = std::max(radius, v.z());
  const Particles p = spheres_of({{{5, 5, radius}, 1}, {{2, 2, 6}, 1}}, 10);
  SurfaceOptions options = whole_box(p, 10);
  EXPECT_EQ(show_surface(p, shapes, options, nullptr).stones, 2);
  options.area_fraction = 0.01;
  EXPECT_EQ(show_surface(p, shapes, options, nullptr).stones, 1);
}

TEST(View, LeavesVoidsOut) {
  Particles p = four_spheres();
  p.voids = {0, 1, 0, 0};
  EXPECT_EQ(show_surface(p, ball(), whole_box(p, 9), nullptr).profiles.profiles.size(), 3u);
  p.voids = {1, 1, 1, 1};
  EXPECT_EQ(test::code_of([&] { show_surface(p, ball(), whole_box(p, 9), nullptr); }), "no-particles");
}

TEST(View, FillsWithSoilUpToThePhotographsShare) {
  Particles p = loose_bed();
  p.binder_color = Vec3f::Constant(0.3f);
  SurfaceOptions options = whole_box(p, 6, 240);
  EXPECT_GT(show_surface(p, ball(), options, nullptr).profiles.area_fraction, 0.5);
  options.area_fraction = 0.3;
  const SurfaceView seen = show_surface(p, ball(), options, nullptr);
  const double soil = pixels_of_labels(seen)[0];
  EXPECT_NEAR(1 - soil / (240.0 * 240), 0.3, 0.01);
  EXPECT_NEAR(seen.profiles.area_fraction, 0.3, 1e-4);
  // Soil has the binder's color on average, and stones theirs in the middle.
  double sum = 0;
  for (std::size_t i = 0; i < seen.labels.ids.size(); ++i)
    if (seen.labels.ids[i] == 0) sum += seen.image.pixels[i].mean();
  EXPECT_NEAR(sum / soil, p.binder_color.mean(), 0.25 * p.binder_color.mean());
}

// Soil lies at the cut, even if the stones cannot cover the photograph's share.
TEST(View, TooFewStonesLieOnSoil) {
  SurfaceOptions options = whole_box(four_spheres(), 5);
  options.area_fraction = 0.6;
  const SurfaceView seen = show_surface(four_spheres(), ball(), options, nullptr);
  EXPECT_EQ(seen.stones, 4);
  double discs = 0;
  for (const double scale : four_spheres().scale) discs += std::numbers::pi * scale * scale / 100;
  EXPECT_NEAR(seen.profiles.area_fraction, discs, 0.01);
  // Half buried, they shade the soil beside them.
  float darkest = 1, usual = seen.image.at(100, 100, 0).mean();
  for (std::size_t i = 0; i < seen.labels.ids.size(); ++i)
    if (seen.labels.ids[i] == 0) darkest = std::min(darkest, seen.image.pixels[i].mean());
  EXPECT_LT(darkest, 0.9F * usual);
}

// Of each size, one layer is seen that is as deep as the stones are high.
TEST(View, ShowsAsManyHeightsOfSmallStonesAsOfLargeOnes) {
  std::vector<Sphere> spheres;
  const Particles large = test::apart_particles(5, 150, 16, 1, 1, ball().shapes[0]);
  const Particles small = test::apart_particles(6, 900, 16, 0.25, 0.25, ball().shapes[0]);
  for (const Particles* all : {&large, &small})
    for (std::size_t i = 0; i < all->count(); ++i) spheres.push_back({all->position[i], all->scale[i]});
  const Particles p = spheres_of(spheres, 16);
  SurfaceOptions options = whole_box(p, 0, 320);
  options.places = choose_places(12, p, ball(), 1);
  // What stones of both sizes within half their height of the cut cover.
  double empty = 1;
  for (const Particles* all : {&large, &small})
    empty *= std::exp(-4 * std::numbers::pi / 3 * std::pow(all->scale[0], 3) * 1.25 * all->count() / 4096);
  options.area_fraction = 1 - empty;
  options.shaded = false;
  const SurfaceView seen = show_surface(p, ball(), options, nullptr);
  double layers[2] = {0, 0};
  for (const auto& row : seen.table.rows) {
    const std::size_t i = std::lround(std::get<double>(row[1]));
    const bool is_small = i >= large.count();
    const double one_layer = 2 * p.scale[i] * (is_small ? small : large).count() / 16 * 12;
    layers[is_small] += 1 / one_layer;
  }
  EXPECT_NEAR(layers[0], 1, 0.25);
  EXPECT_NEAR(layers[1], 1, 0.25);  // and not several, of all small stones that large ones hide
}

TEST(View, GivesStonesTheirColorsInTheMiddle) {
  const Particles p = four_spheres();
  const SurfaceView seen = show_surface(p, ball(), whole_box(p, 9), nullptr);
  std::vector<float> stones;
  for (std::size_t i = 0; i < seen.labels.ids.size(); ++i)
    if (seen.labels.ids[i] > 0) stones.push_back(seen.image.pixels[i].x());
  std::nth_element(stones.begin(), stones.begin() + stones.size() / 2, stones.end());
  EXPECT_NEAR(stones[stones.size() / 2], 0.3, 0.01);
}

TEST(View, IsTheSameOnAnyNumberOfThreads) {
  const std::multimap<std::string, Value> inputs = {{"particles", Value::of(loose_bed())},
                                                    {"shapes", Value::of(ball())}};
  const std::map<std::string, std::string> parameters = {
      {"view", "surface"}, {"pictures", "2"}, {"pixel_size", "0.1"}};
  const auto one = run_node("View", inputs, parameters, {}, 1);
  const auto four = run_node("View", inputs, parameters, {}, 4);
  EXPECT_EQ(one.output<Image>("image").pixels, four.output<Image>("image").pixels);
  EXPECT_EQ(one.output<Labels>("labels").ids, four.output<Labels>("labels").ids);
  EXPECT_EQ(one.metrics, four.metrics);
  EXPECT_EQ(one.output<Image>("image").sections, 2);
  EXPECT_GT(one.metrics.at("particles_shown"), 20);
}

// Mean brightness of the largest sphere on the side of a direction in the picture, over that of the other.
double lit_ratio(double azimuth) {
  const Particles p = four_spheres();
  SurfaceOptions options = whole_box(p, 9);
  options.light = light_of(std::nullopt, azimuth, std::nullopt);
  const SurfaceView seen = show_surface(p, ball(), options, nullptr);
  const Vec2 center = p.position[0].head<2>() / options.pixel_size;
  const double turn = azimuth * std::numbers::pi / 180;
  double lit = 0;
  double dark = 0;
  for (int row = 0; row < 200; ++row)
    for (int x = 0; x < 200; ++x) {
      if (seen.labels.ids[seen.labels.index(x, row)] != 1) continue;
      const Vec2 from = Vec2(x + 0.5, 199.5 - row) - center;
      const double along = from.dot(Vec2(std::cos(turn), std::sin(turn)));
      (along > 0 ? lit : dark) += seen.image.at(x, row).mean();
    }
  return lit / dark;
}

TEST(View, LightsTheSideThatFacesTheSun) {
  EXPECT_GT(lit_ratio(0), 1.2);   // from the right
  EXPECT_GT(lit_ratio(90), 1.2);  // from above in the picture
  EXPECT_GT(lit_ratio(-135), 1.2);
}

TEST(View, TakesTheLightFromTheProfiles) {
  const Light strong = light_of(Vec2(0, 0.8), std::nullopt, std::nullopt);
  EXPECT_NEAR(strong.azimuth, 90, 1e-9);
  EXPECT_NEAR(strong.elevation, 40, 1e-9);
  EXPECT_NEAR(strong.share / std::tan(strong.elevation * std::numbers::pi / 180), 0.8, 1e-9);
  const Light flat = light_of(Vec2(0, 0), std::nullopt, std::nullopt);
  EXPECT_NEAR(flat.share, 0.15, 1e-9);
  EXPECT_NEAR(flat.azimuth, 135, 1e-9);
  const Light turned = light_of(Vec2(0, 0.5), 0.0, 20.0);
  EXPECT_NEAR((turned.slope - Vec2(0.5, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(turned.elevation, 20, 1e-12);
}

TEST(View, CutsPlanesAsSectionDoes) {
  const std::multimap<std::string, Value> inputs = {{"particles", Value::of(loose_bed())},
                                                    {"shapes", Value::of(ball())}};
  const auto planes = run_node("Section", inputs,
                               {{"axis", "random"}, {"planes", "2"}, {"pixel_size", "0.1"}, {"seed", "7"}});
  for (const char* name : {"section", "filling"}) {
    const auto seen =
        run_node("View", inputs, {{"view", name}, {"pictures", "2"}, {"pixel_size", "0.1"}, {"seed", "7"}});
    EXPECT_EQ(seen.output<Image>("image").pixels, planes.output<Image>("image").pixels);
    EXPECT_EQ(seen.output<Labels>("labels").ids, planes.output<Labels>("labels").ids);
    EXPECT_STREQ(name_of(seen.output<Profiles>("profiles").view), name);
  }
}

TEST(View, FollowsThePhotograph) {
  Profiles photograph;
  photograph.area_fraction = 0.25;
  photograph.light = Vec2(0.3, 0);
  const auto metrics_with = [&](terrazzo::View view, const std::string& word) {
    photograph.view = view;
    const auto run = run_node("View",
                              {{"particles", Value::of(four_spheres())},
                               {"shapes", Value::of(ball())},
                               {"like", Value::of(Image(90, 60, 1, 0.1))},
                               {"profiles", Value::of(photograph)}},
                              {{"view", word}});
    EXPECT_EQ(run.output<Image>("image").width, 90);
    EXPECT_EQ(run.output<Image>("image").height, 60);
    return run.metrics;
  };
  EXPECT_EQ(metrics_with(terrazzo::View::Surface, "auto").at("view_surface"), 1);
  EXPECT_EQ(metrics_with(terrazzo::View::Filling, "auto").at("view_filling"), 1);
  EXPECT_EQ(metrics_with(terrazzo::View::Section, "auto").at("view_section"), 1);
  EXPECT_EQ(metrics_with(terrazzo::View::Section, "surface").at("view_surface"), 1);
  EXPECT_EQ(metrics_with(terrazzo::View::Surface, "section").at("view_surface"), 0);
  const auto alone =
      run_node("View", {{"particles", Value::of(four_spheres())}, {"shapes", Value::of(ball())}});
  EXPECT_EQ(alone.metrics.at("view_section"), 1);
}

Detail noise() {
  Detail d;
  d.pixel_size = 0.1;
  d.size = 16;
  for (std::uint64_t k = 0; k < 2; ++k) {
    Detail::Phase phase;
    for (std::uint64_t i = 0; i < 16 * 16 * 16; ++i)
      phase.tile.push_back(Vec3f::Constant(static_cast<float>(0.05 * Random(1, k, i).normal())));
    d.phases.push_back(std::move(phase));
  }
  return d;
}

TEST(View, DetailBelongsToTheStones) {
  const Particles p = four_spheres();
  const residual::ResidualField field(noise(), p, 0.05, residual::Keep::Power);
  SurfaceOptions options = whole_box(p, 9);
  const SurfaceView flat = show_surface(p, ball(), options, nullptr);
  const SurfaceView seen = show_surface(p, ball(), options, &field);
  EXPECT_EQ(flat.labels.ids, seen.labels.ids);
  EXPECT_NE(flat.image.pixels, seen.image.pixels);
  // A picture 20 pixels and one period aside shows other copies with the same texture in other pixels.
  options.places[0].corner = Vec2(10 + 20 * options.pixel_size, -10);
  const SurfaceView aside = show_surface(p, ball(), options, &field);
  double same = 0;
  double other = 0;
  int pixels = 0;
  for (int row = 0; row < 200; ++row)
    for (int x = 20; x < 200; ++x) {
      if (seen.labels.ids[seen.labels.index(x, row)] == 0) continue;
      same += (seen.image.at(x, row) - aside.image.at(x - 20, row)).cwiseAbs().mean();
      other += (seen.image.at(x, row) - flat.image.at(x, row)).cwiseAbs().mean();
      ++pixels;
    }
  EXPECT_LT(same / pixels, 0.2 * other / pixels);
}

TEST(View, RefusesTooManyPixels) {
  const Particles p = four_spheres();
  SurfaceOptions options = whole_box(p, 9, 8300);
  EXPECT_EQ(test::code_of([&] { show_surface(p, ball(), options, nullptr); }), "too-many-pixels");
}

TEST(View, OutlinesPixelsCounterclockwise) {
  // An L with a pixel that touches it only at a corner.
  const std::vector<std::int32_t> ids = {0, 1, 0, 0,  //
                                         0, 1, 0, 1,  //
                                         0, 1, 1, 0};
  const Loop outline = outline_of_pixels(ids, 4, 3, 1, 0);
  EXPECT_EQ(outline.size(), 10u);  // one point for each outer edge
  EXPECT_GT(loop_area(outline), 2);
  EXPECT_LT(loop_area(outline), 4);
  for (const Vec2& v : outline) EXPECT_LE(v.x(), 3);
}

}  // namespace
}  // namespace terrazzo

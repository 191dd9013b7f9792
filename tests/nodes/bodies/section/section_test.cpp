#include "nodes/bodies/cutting/section.h"

#include <gtest/gtest.h>

#include "nodes/common/geometry/grid/slice_axes.h"
#include "nodes/common/geometry/mesh/mesh_section.h"
#include "tests/nodes/bodies/section/packing.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace section;

using test::apart_particles;
using test::random_particles;
using test::run_node;

Section cut(const Particles& p, const Shapes& shapes, const SectionOptions& choice, double pixel = 0.05) {
  return cut_section(p, shapes, choose_planes(choice, p.box, true, pixel));
}

Particles one_cube(const Vec3& at, double box = 4) {
  Particles p;
  p.box = Vec3::Constant(box);
  p.resize(1);
  p.position[0] = at;
  p.color[0] = Vec3f(1, 0.5f, 0);
  return p;
}

TEST(Section, ACubeAcrossTheTilesCornerCountsOnceAndWhole) {
  const Shapes shapes{{test::cube()}};
  SectionOptions choice;
  choice.offsets = {0.1};  // reached only by the cube's periodic image below the box
  const Particles p = one_cube({3.9, 0.2, 3.8});
  const Section s = cut(p, shapes, choice);
  ASSERT_EQ(s.profiles.profiles.size(), 1u);
  const Profile& q = s.profiles.profiles[0];
  EXPECT_NEAR(q.area, 1, 1e-12);
  EXPECT_NEAR(q.centroid.x(), 3.9, 1e-12);
  EXPECT_NEAR(q.centroid.y(), 0.2, 1e-12);
  EXPECT_EQ(q.weight, 1);
  EXPECT_FALSE(q.touches_border);
  EXPECT_NEAR(loop_area(q.contour), 1, 1e-12);
  EXPECT_NEAR(s.profiles.area_fraction, 1.0 / 16, 1e-9);
  // Its four parts are in the tile's four corners; rows count from the top.
  const int w = s.labels.width, h = s.labels.height;
  ASSERT_EQ(w, 80);
  EXPECT_EQ(s.labels.ids[s.labels.index(0, 0)], 1);
  EXPECT_EQ(s.labels.ids[s.labels.index(w - 1, 0)], 1);
  EXPECT_EQ(s.labels.ids[s.labels.index(0, h - 1)], 1);
  EXPECT_EQ(s.labels.ids[s.labels.index(w - 1, h - 1)], 1);
  EXPECT_EQ(s.labels.ids[s.labels.index(w / 2, h / 2)], 0);
}

TEST(Section, AxesShowTheirFacesTheRightWayUp) {
  const Shapes shapes{{test::cube()}};
  Particles p = one_cube({1, 2, 3});
  for (int u = 0; u < 3; ++u) {
    SectionOptions choice;
    choice.axis = std::string(1, static_cast<char>('x' + u));
    choice.offsets = {p.position[0][u]};
    const Section s = cut(p, shapes, choice);
    ASSERT_EQ(s.profiles.profiles.size(), 1u);
    EXPECT_NEAR(s.profiles.profiles[0].centroid.x(), p.position[0][kSliceColumns[u]], 1e-12);
    EXPECT_NEAR(s.profiles.profiles[0].centroid.y(), p.position[0][kSliceRows[u]], 1e-12);
  }
}

TEST(Section, AFreePlaneIsPlacedByItsNormalAndAPoint) {
  const Shapes shapes{{test::cube()}};
  const Particles p = one_cube({2, 2, 2});
  SectionOptions choice;
  choice.axis = "free";
  choice.width = choice.height = 4;
  for (const auto& [normal, area] : {std::pair(Vec3(0, 0, 2), 1.0),
                                     {Vec3(1, 1, 0), std::sqrt(2.0)},
                                     {Vec3(1, 1, 1), 0.75 * std::sqrt(3.0)}}) {
    choice.normal = normal;
    choice.through.reset();
    const Section s = cut(p, shapes, choice);
    ASSERT_EQ(s.profiles.profiles.size(), 1u);
    EXPECT_NEAR(s.profiles.profiles[0].area, area, 1e-9) << normal.transpose();
    EXPECT_NEAR(s.profiles.profiles[0].centroid.x(), 2, 1e-9);
    EXPECT_NEAR(s.profiles.profiles[0].centroid.y(), 2, 1e-9);
    choice.through = Vec3(2, 2, 2) + 0.9 * normal.normalized();
    EXPECT_TRUE(cut(p, shapes, choice).profiles.profiles.empty());
  }
  // z is upwards where the plane allows it.
  choice.normal = Vec3(1, 0, 0);
  EXPECT_NEAR((choose_planes(choice, p.box, true, 0.1).planes[0].frame.col(1) - Vec3::UnitZ()).norm(), 0,
              1e-12);
  choice.normal = Vec3::Zero();
  EXPECT_EQ(test::code_of([&] { choose_planes(choice, p.box, true, 0.1); }), "bad-normal");
}

TEST(Section, PictureLabelsAndProfilesAgree) {
  const Shapes shapes{{test::cube()}};
  const Particles p = apart_particles(2, 3000, 10, 0.5, 1.5, shapes.shapes[0]);
  for (const char* axis : {"z", "random"}) {
    SectionOptions choice;
    choice.axis = axis;
    choice.planes = 2;
    const Section s = cut(p, shapes, choice, 0.02);
    const double pixel = s.image.pixel_size * s.image.pixel_size;
    std::vector<double> pixels(s.profiles.profiles.size() + 1, 0.0);
    for (std::int32_t id : s.labels.ids) ++pixels.at(id);
    ASSERT_EQ(s.labels.classes.size(), s.profiles.profiles.size());
    double exact = 0;
    for (std::size_t k = 0; k < s.profiles.profiles.size(); ++k) {
      const Profile& q = s.profiles.profiles[k];
      exact += q.area;
      // Labels by pixel centers approximate the area up to about half a pixel along the outline.
      EXPECT_NEAR(pixels[k + 1] * pixel, q.area, 4 * pixel + 0.35 * s.image.pixel_size * std::sqrt(q.area))
          << k;
      EXPECT_EQ(s.labels.classes[k], q.cls);
    }
    EXPECT_NEAR(s.profiles.area_fraction * s.profiles.observed_area / exact, 1, 1e-7);
    // Coverage is exact: the image's mean is the area-weighted mean of the colors, up to rounding.
    Eigen::Vector3d mean = Eigen::Vector3d::Zero(), expected = Eigen::Vector3d::Zero();
    for (const Vec3f& c : s.image.pixels) mean += c.cast<double>();
    mean /= static_cast<double>(s.image.pixels.size());
    for (const Profile& q : s.profiles.profiles) expected += q.color.cast<double>() * q.area;
    expected += p.binder_color.cast<double>() * (s.profiles.observed_area - exact);
    expected /= s.profiles.observed_area;
    EXPECT_NEAR((mean - expected).norm(), 0, 1e-5);
  }
}

TEST(Section, OverlapsCountOnce) {
  const Shapes shapes{{test::cube()}};
  Particles p = one_cube({1, 1, 1});
  p.resize(3);
  p.position[1] = {1.5, 1.25, 1};                     // shares 0.5 × 0.75 with the first
  p.position[2] = p.position[0] + Vec3(1e-12, 0, 0);  // a copy of the first
  p.orientation[1] = p.orientation[2] = Quat::Identity();
  SectionOptions choice;
  choice.offsets = {1};
  const Section s = cut(p, shapes, choice);
  EXPECT_EQ(s.profiles.profiles.size(), 3u);
  EXPECT_NEAR(s.profiles.area_fraction * 16, 2 - 0.375, 1e-7);
  EXPECT_NEAR(s.overlap * 16, 1.375, 1e-7);
}

TEST(Section, BoxesThatTouchFillThePlane) {
  const Shapes shapes{{test::cube(2)}};
  Particles p = one_cube({1, 1, 1});
  p.resize(4);
  for (int i = 0; i < 4; ++i) {
    p.position[i] = {i % 2 ? 3.0 : 1.0, i / 2 ? 3.0 : 1.0, 1};
    p.scale[i] = 1;
  }
  SectionOptions choice;
  choice.offsets = {1};
  const Section s = cut(p, shapes, choice);
  EXPECT_NEAR(s.profiles.area_fraction, 1, 1e-8);
  EXPECT_EQ(s.overlap, 0);
  for (std::int32_t id : s.labels.ids) EXPECT_GT(id, 0);
}

TEST(Section, BordersOfRandomWindowsAreWeighted) {
  const Shapes shapes{{test::cube()}};
  const Particles p = random_particles(4, 300, 10, 0.8, 1.6);
  SectionOptions choice;
  choice.axis = "random";
  choice.planes = 20;
  choice.width = 6;
  choice.height = 3;
  const Section s = cut(p, shapes, choice);
  EXPECT_DOUBLE_EQ(s.profiles.observed_area, 360);
  int cut_ones = 0;
  for (const Profile& q : s.profiles.profiles) {
    Vec2 lo = q.contour[0], hi = lo;
    for (const Vec2& v : q.contour) {
      lo = lo.cwiseMin(v);
      hi = hi.cwiseMax(v);
    }
    EXPECT_GE(lo.minCoeff(), 0);
    EXPECT_LE(hi.x(), 6);
    EXPECT_LE(hi.y(), 3);
    if (q.touches_border) {
      ++cut_ones;
      EXPECT_EQ(q.weight, 0);
    } else {
      EXPECT_NEAR(q.weight, 18 / ((6 - hi.x() + lo.x()) * (3 - hi.y() + lo.y())), 1e-9);
    }
  }
  EXPECT_GT(cut_ones, 20);
}

TEST(Section, IsTheSameForAnyNumberOfThreads) {
  const Shapes shapes{{test::cube(), test::square_ring()}};
  const Particles p = random_particles(6, 500, 10, 0.4, 1.2, 2);
  std::vector<std::vector<char>> bytes;
  for (int threads : {1, 2}) {
    const auto run = run_node("Section", {{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}},
                              {{"axis", "random"}, {"planes", "3"}, {"pixel_size", "0.05"}}, {}, threads);
    BufferWriter writer;
    for (const auto& [name, value] : run.outputs) value.type().encode(value.data(), writer);
    bytes.push_back(writer.buffer);
  }
  EXPECT_GT(bytes[0].size(), 100000u);
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST(Section, ReportsWhatItShows) {
  const Shapes shapes{{test::cube()}};
  const Particles p = apart_particles(8, 2000, 8, 0.5, 1.2, shapes.shapes[0]);
  const auto run =
      run_node("Section", {{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}}, {{"planes", "4"}});
  const auto& profiles = run.output<Profiles>("profiles");
  EXPECT_EQ(run.output<Image>("image").width, 512);
  EXPECT_EQ(run.output<Image>("image").sections, 4);
  EXPECT_EQ(run.metrics.at("profiles"), profiles.profiles.size());
  EXPECT_DOUBLE_EQ(run.metrics.at("area_fraction"), profiles.area_fraction);
  EXPECT_DOUBLE_EQ(run.metrics.at("profiles_per_area"), profiles.profiles.size() / (4 * 64.0));
  EXPECT_EQ(run.output<Table>("table").rows.size(), profiles.profiles.size());
  EXPECT_TRUE(run.warnings.empty());
}

std::string code_of(const std::multimap<std::string, Value>& inputs,
                    const std::map<std::string, std::string>& parameters = {}) {
  return test::code_of([&] { run_node("Section", inputs, parameters); });
}

TEST(Section, SaysWhatIsWrong) {
  const Value shapes = Value::of(Shapes{{test::cube()}});
  Particles good = one_cube({1, 1, 1}), none = good, wrong = good, nan = good, flat = good;
  none.resize(0);
  wrong.shape[0] = 3;
  nan.position[0].x() = NAN;
  flat.box.z() = 0;
  auto with = [&](const Particles& p) {
    return std::multimap<std::string, Value>{{"particles", Value::of(p)}, {"shapes", shapes}};
  };
  EXPECT_EQ(code_of(with(good)), "");
  EXPECT_EQ(code_of({}), "missing-input");
  EXPECT_EQ(code_of({{"particles", Value::of(good)}}), "missing-input");
  EXPECT_EQ(code_of({{"shapes", shapes}}), "missing-input");
  EXPECT_EQ(code_of({{"particles", Value::of(good)}, {"shapes", Value::of(Shapes{})}}), "no-shapes");
  EXPECT_EQ(code_of(with(none)), "no-particles");
  EXPECT_EQ(code_of(with(wrong)), "no-such-shape");
  EXPECT_EQ(code_of(with(nan)), "bad-particle");
  EXPECT_EQ(code_of(with(flat)), "bad-box");
  EXPECT_EQ(code_of(with(good), {{"offsets", "[1, 4.5]"}}), "bad-offset");
  EXPECT_EQ(code_of(with(good), {{"offsets", "[1, 2]"}, {"planes", "3"}}), "planes-and-offsets");
  EXPECT_EQ(code_of(with(good), {{"offsets", "1"}, {"axis", "random"}}), "offsets-at-random");
  EXPECT_EQ(code_of(with(good), {{"width", "1"}}), "window-on-axis");
  EXPECT_EQ(code_of(with(good), {{"pixel_size", "1e-6"}}), "too-many-pixels");
}

TEST(Section, APlaneThatMeetsNothingWarns) {
  const auto run =
      run_node("Section",
               {{"particles", Value::of(one_cube({1, 1, 1}))}, {"shapes", Value::of(Shapes{{test::cube()}})}},
               {{"offsets", "3"}});
  EXPECT_EQ(run.output<Profiles>("profiles").profiles.size(), 0u);
  EXPECT_EQ(run.metrics.at("area_fraction"), 0);
  EXPECT_EQ(run.warnings.size(), 1u);
}

}  // namespace
}  // namespace terrazzo

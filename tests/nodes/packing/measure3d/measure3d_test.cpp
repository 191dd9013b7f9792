// The node: particles from meshes and labels, periodicity, phases, errors.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "nodes/data/image.h"
#include "nodes/data/shapes.h"
#include "nodes/data/table.h"
#include "tests/nodes/packing/measure3d/blocks.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using test::NodeRun;
using Inputs = std::multimap<std::string, Value>;
using Parameters = std::map<std::string, std::string>;

Shapes shape_of(const Parameters& parameters) {
  return test::run_node("Shape", {}, parameters).output<Shapes>("shapes");
}

Particles at_points(const Vec3& box, const std::vector<Vec3>& points) {
  Particles p;
  p.box = box;
  p.resize(points.size());
  p.position = points;
  p.size.assign(points.size(), 1);
  return p;
}

NodeRun measure(Inputs inputs, const Parameters& parameters = {}) {
  return test::run_node("Measure3D", inputs, parameters);
}

double value_of(const NodeRun& run, const std::string& measure) {
  const auto& t = run.output<Table>("table");
  for (std::size_t k = 0; k < t.rows.size(); ++k)
    if (std::get<std::string>(t.rows[k][0]) == measure) return t.number(k, "value");
  ADD_FAILURE() << "no measure " << measure;
  return 0;
}

Vec3 extent_of(const Mesh& mesh) {
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return high - low;
}

// Axes of 3, 2, 1 times a length, turned so that the longest is along y and the shortest along x.
TEST(Measure3D, KnowsAnEllipsoid) {
  const Shapes shapes = shape_of({{"kind", "ellipsoid"}, {"axes", "[3, 2, 1]"}, {"detail", "5"}});
  const Vec3 extent = extent_of(shapes.shapes[0].mesh);
  ASSERT_NEAR(extent[0] / extent[2], 3, 0.01);
  Particles p = at_points(Vec3::Constant(10 * extent[0]), {Vec3(1, 2, 3)});
  p.scale[0] = 2;
  Mat3 turn;
  turn << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  p.orientation[0] = Quat(turn);
  const NodeRun run = measure({{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}});
  const auto& t = run.output<Table>("particles");
  ASSERT_EQ(t.rows.size(), 1u);
  EXPECT_NEAR(t.number(0, "long mm") / (2 * extent[0]), 1, 0.003);
  EXPECT_NEAR(t.number(0, "middle mm") / (2 * extent[1]), 1, 0.003);
  EXPECT_NEAR(t.number(0, "short mm") / (2 * extent[2]), 1, 0.003);
  EXPECT_NEAR(t.number(0, "volume mm³") / (8 * M_PI / 6 * extent.prod()), 1, 0.005);
  EXPECT_NEAR(std::abs(t.number(0, "long_y")), 1, 1e-6);
  EXPECT_NEAR(std::abs(t.number(0, "short_x")), 1, 1e-6);
  EXPECT_NEAR(t.number(0, "elongation"), 2.0 / 3, 0.003);
  EXPECT_NEAR(t.number(0, "flatness"), 0.5, 0.003);
  EXPECT_NEAR(value_of(run, "nematic order"), 1, 1e-9);
  EXPECT_NEAR(value_of(run, "orientation tensor yy"), 1, 1e-9);
}

// A uniform box of edge a has the moment a²/12 and the ellipsoid axis a·√(5/3).
TEST(Measure3D, KnowsABox) {
  const Shapes shapes = shape_of({{"kind", "box"}, {"axes", "[4, 2, 1]"}});
  const Vec3 extent = extent_of(shapes.shapes[0].mesh);
  const Particles p = at_points(Vec3::Constant(10 * extent[0]), {Vec3(1, 2, 3)});
  const NodeRun run = measure({{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}});
  const auto& t = run.output<Table>("particles");
  EXPECT_NEAR(t.number(0, "long mm"), extent[0] * std::sqrt(5.0 / 3), 1e-9 * extent[0]);
  EXPECT_NEAR(t.number(0, "short mm"), extent[2] * std::sqrt(5.0 / 3), 1e-9 * extent[0]);
  EXPECT_NEAR(t.number(0, "volume mm³"), extent.prod(), 1e-9 * extent.prod());
  EXPECT_NEAR(value_of(run, "specific surface, meshes"),
              2 * (extent[0] * extent[1] + extent[1] * extent[2] + extent[0] * extent[2]) / p.box.prod(),
              1e-9);
}

std::vector<Vec3> lattice(int n, double spacing, double shift) {
  std::vector<Vec3> out;
  for (int i = 0; i < n * n * n; ++i)
    out.push_back(Vec3(i % n, i / n % n, i / n / n) * spacing + Vec3::Constant(shift));
  return out;
}

TEST(Measure3D, BallsOfACubicLatticeHaveSixContacts) {
  const Shapes shapes = shape_of({{"kind", "sphere"}, {"detail", "4"}});
  const double d = extent_of(shapes.shapes[0].mesh).x();
  for (const double shift : {0.0, 0.37}) {
    const Particles p = at_points(Vec3::Constant(4 * d), lattice(4, d, shift * d));
    const NodeRun run = measure({{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}},
                                {{"contact_gap", fmt::format("{}", 0.01 * d)}});
    EXPECT_EQ(value_of(run, "mean contacts"), 6);
    EXPECT_EQ(value_of(run, "sd of contacts"), 0);
    EXPECT_EQ(run.output<Table>("contacts").rows.size(), 64u * 3);
    const auto& histogram = run.output<Table>("distributions");
    double share = 0;
    for (std::size_t k = 0; k < histogram.rows.size(); ++k)
      if (std::get<std::string>(histogram.rows[k][0]) == "contacts" && histogram.number(k, "from") == 5.5)
        share = histogram.number(k, "share");
    EXPECT_NEAR(share, 1, 1e-12);
    // Balls a little farther apart than the gap have none.
    Particles apart = p;
    for (double& s : apart.scale) s = 0.98;
    EXPECT_EQ(value_of(measure({{"particles", Value::of(apart)}, {"shapes", Value::of(shapes)}},
                               {{"contact_gap", fmt::format("{}", 0.01 * d)}}),
                       "mean contacts"),
              0);
  }
}

// The rim of both boxes' sides adds four times the gap, and the two halves of the mean are equal.
TEST(Measure3D, BoxesFaceToFaceTouchWithTheirFaces) {
  const Shapes shapes = shape_of({{"kind", "box"}});
  const double a = extent_of(shapes.shapes[0].mesh).x();
  // The contact is across the side of the periodic box.
  const Particles p = at_points(Vec3(8, 8, 8) * a, {Vec3(0.3, 4, 4) * a, Vec3(7.3, 4, 4) * a});
  const NodeRun run = measure({{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}},
                              {{"contact_gap", fmt::format("{}", 0.001 * a)}});
  const auto& t = run.output<Table>("contacts");
  ASSERT_EQ(t.rows.size(), 1u);
  EXPECT_NEAR(t.number(0, "area mm²") / (a * a), 1, 0.01);
  EXPECT_EQ(run.output<Table>("particles").number(1, "contacts"), 1);
}

// Two ellipsoids and a box of labels, of which the first crosses three sides.
std::int32_t some_label(const Vec3i& n, int x, int y, int z, const Vec3i& shift) {
  const Vec3 edge = n.cast<double>();
  const Vec3 p = Vec3(x, y, z) + Vec3::Constant(0.5) - shift.cast<double>();
  if (nearest_image(p - Vec3(2, 3, 1), edge).cwiseQuotient(Vec3(12, 8, 6)).norm() < 1) return 7;
  if (nearest_image(p - Vec3(20, 20, 20), edge).cwiseQuotient(Vec3(5, 9, 7)).norm() < 1) return 2;
  const Vec3 d = nearest_image(p - Vec3(29, 20, 20), edge).cwiseAbs();
  return d.x() < 4 && d.y() < 6 && d.z() < 6 ? 4 : -1;
}

TEST(Measure3D, LabelsWrapAndAShiftChangesNothing) {
  const Vec3i n(48, 40, 36);
  std::vector<NodeRun> runs;
  for (const Vec3i& shift : {Vec3i(0, 0, 0), Vec3i(11, 29, 17)})
    runs.push_back(measure({{"volume", Value::of(test::label_volume(n, 0.5, true, [&](int x, int y, int z) {
                               return some_label(n, x, y, z, shift);
                             }))}}));
  const auto &a = runs[0].output<Table>("particles"), &b = runs[1].output<Table>("particles");
  ASSERT_EQ(a.rows.size(), 3u);
  EXPECT_EQ(a.number(2, "index"), 7);
  EXPECT_NEAR(a.number(2, "long mm"), 12, 0.1);
  EXPECT_NEAR(a.number(2, "middle mm"), 8, 0.1);
  EXPECT_NEAR(a.number(2, "short mm"), 6, 0.1);
  EXPECT_NEAR(a.number(2, "volume mm³") / (M_PI / 6 * 12 * 8 * 6), 1, 0.01);
  EXPECT_NEAR(std::abs(a.number(2, "long_x")), 1, 1e-3);
  EXPECT_NEAR(a.number(2, "x mm"), 1, 0.01);
  EXPECT_NEAR(a.number(2, "z mm"), 0.5, 0.01);
  for (std::size_t row = 0; row < 3; ++row)
    for (const char* column :
         {"index", "volume mm³", "long mm", "middle mm", "short mm", "contacts", "contact_area mm²", "cut"})
      EXPECT_NEAR(a.number(row, column), b.number(row, column), 1e-9) << row << column;
  ASSERT_EQ(runs[0].output<Table>("contacts").rows.size(), 1u);  // 2 and 4
  EXPECT_EQ(runs[0].output<Table>("contacts").number(0, "a"), 2);
  EXPECT_EQ(runs[0].output<Table>("contacts").number(0, "b"), 4);
  const auto &c = runs[0].output<Table>("correlation"), &d = runs[1].output<Table>("correlation");
  ASSERT_EQ(c.rows.size(), d.rows.size());
  for (std::size_t row = 0; row < c.rows.size(); ++row) {
    for (const char* column : {"S2_x", "S2_y", "S2_z", "S2_mean"})
      EXPECT_NEAR(c.number(row, column), d.number(row, column), 1e-6);
    for (const char* column : {"L_x", "L_y", "L_z"}) EXPECT_EQ(c.number(row, column), d.number(row, column));
  }
  for (const char* name : {"specific surface, voxels", "integral range", "mean chord"})
    EXPECT_NEAR(value_of(runs[0], name) / value_of(runs[1], name), 1, 1e-9) << name;
  EXPECT_TRUE(runs[0].output<Image>("figure").width > 0);
}

// Cubes of labels fill the box: each has six neighbors and touches them with its faces.
TEST(Measure3D, CubesThatFillTheBoxHaveSixNeighbors) {
  const NodeRun run = measure(
      {{"volume", Value::of(test::label_volume(Vec3i::Constant(24), 0.25, true, [](int x, int y, int z) {
          return x / 8 + 3 * (y / 8) + 9 * (z / 8);
        }))}});
  EXPECT_EQ(value_of(run, "particles"), 27);
  EXPECT_NEAR(value_of(run, "mean contacts"), 6, 1e-9);
  // Of 8 × 8 voxels in a face, 56 have a diagonal neighbor in the same other cube along a face's diagonal,
  // and 49 along the cube's. The weights are those of Lang, Ohser and Hilfer 2001.
  const double share =
      4 * 0.045778 + 16 * 0.036981 * 56 / 64 / std::sqrt(2.0) + 16 * 0.035196 * 49 / 64 / std::sqrt(3.0);
  EXPECT_NEAR(value_of(run, "mean contact area of a pair") / 4, share, 0.003);
  EXPECT_EQ(value_of(run, "specific surface, voxels"), 0);
}

TEST(Measure3D, ParticlesAtTheBorderOfABlockAreLeftOut) {
  // The binder is active nowhere, so two labels at the corners mark the box.
  const auto run = measure(
      {{"volume", Value::of(test::label_volume(Vec3i::Constant(20), 1, false, [](int x, int y, int z) {
          if (x + y + z == 0) return 0;
          if (x + y + z == 57) return 1;
          return x > 4 && x < 10 && y > 4 && y < 10 && z > 4 && z < 10 ? 2 : -1;
        }))}});
  EXPECT_EQ(value_of(run, "particles"), 1);
  EXPECT_EQ(value_of(run, "mean volume"), 125);
  EXPECT_EQ(run.output<Table>("particles").rows.size(), 3u);
  ASSERT_FALSE(run.warnings.empty());
  EXPECT_NE(run.warnings[0].find("2 of 3 particles touch the border"), std::string::npos);
}

TEST(Measure3D, PhasesAddUp) {
  const Vec3i n = Vec3i::Constant(16);
  const Value volume = Value::of(test::label_volume(n, 1, true, [](int x, int y, int) {
    return x < 4 ? 0 : y < 3 ? 1 : -1;
  }));
  Particles p = at_points(Vec3::Constant(16), {Vec3::Zero(), Vec3::Zero()});
  p.voids = {0, 1};
  const Shapes shapes = shape_of({{"kind", "sphere"}, {"detail", "1"}});
  const auto fraction = [&](const char* phase) {
    return value_of(measure({{"volume", volume}, {"particles", Value::of(p)}, {"shapes", Value::of(shapes)}},
                            {{"phase", phase}}),
                    "volume fraction, voxels");
  };
  EXPECT_NEAR(fraction("particles"), 0.25, 1e-12);
  EXPECT_NEAR(fraction("voids"), 0.75 * 3 / 16, 1e-12);
  EXPECT_NEAR(fraction("binder"), 0.75 * 13 / 16, 1e-12);
}

TEST(Measure3D, ADensityIsCutAtTheThreshold) {
  Volume v;
  add_number_grid(v, "density", Vec3i(10, 8, 8), Vec3::Ones(), {},
                  [](std::size_t i) { return static_cast<float>(i % 10) / 10; });
  v.resolution = Vec3i(10, 8, 8);
  EXPECT_NEAR(
      value_of(measure({{"volume", Value::of(v)}}, {{"threshold", "0.75"}}), "volume fraction, voxels"), 0.2,
      1e-12);
  EXPECT_TRUE(measure({{"volume", Value::of(v)}}).output<Table>("particles").rows.empty());
}

TEST(Measure3D, LabelsBelowTheThresholdAreBinder) {
  // A label that reaches across the box would be a phase.
  const Value labels = Value::of(test::label_volume(
      Vec3i::Constant(12), 1, true, [](int x, int y, int z) { return y < 11 && z < 11 ? x / 3 : -1; }));
  EXPECT_EQ(value_of(measure({{"volume", labels}}), "particles"), 4);
  const NodeRun run = measure({{"volume", labels}}, {{"threshold", "1"}});
  EXPECT_EQ(value_of(run, "particles"), 3);
  EXPECT_NEAR(value_of(run, "volume fraction, voxels"), 0.75 * 121 / 144, 1e-12);
  EXPECT_EQ(run.output<Table>("particles").number(0, "index"), 1);
}

TEST(Measure3D, BadInputIsNamed) {
  const auto code = [](const Inputs& inputs, const Parameters& parameters = {}) {
    return test::code_of([&] { measure(inputs, parameters); });
  };
  const Shapes shapes = shape_of({{"kind", "sphere"}, {"detail", "1"}});
  Particles p = at_points(Vec3::Constant(16), {Vec3::Zero()});
  const Value volume = Value::of(
      test::label_volume(Vec3i::Constant(8), 1, true, [](int x, int, int) { return x < 4 ? 3 : -1; }));
  EXPECT_EQ(code({}), "missing-input");
  EXPECT_EQ(code({{"particles", Value::of(p)}}), "missing-input");
  EXPECT_EQ(code({{"particles", Value::of(p)}, {"shapes", Value::of(Shapes{})}}), "no-such-shape");
  EXPECT_EQ(code({{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}, {"volume", volume}}),
            "size-mismatch");
  EXPECT_EQ(code({{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}}, {{"phase", "voids"}}),
            "no-particles");
  EXPECT_EQ(code({{"volume", volume}}, {{"phase", "voids"}}), "missing-input");
  EXPECT_EQ(code({{"volume", volume}}, {{"grid", "nothing"}}), "no-such-grid");
  EXPECT_EQ(code({{"volume", Value::of(Volume{})}}), "no-grids");
  p.box.x() = 0;
  EXPECT_EQ(code({{"particles", Value::of(p)}, {"shapes", Value::of(shapes)}}), "bad-box");
}

}  // namespace
}  // namespace terrazzo

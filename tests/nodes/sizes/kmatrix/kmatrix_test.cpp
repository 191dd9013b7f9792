#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/stereology/shape_measures.h"
#include "nodes/common/stereology/size_kernel.h"
#include "nodes/shapes/shape/solids.h"
#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "nodes/sizes/kmatrix/section_statistics.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace shape;
using namespace kmatrix;

using std::numbers::pi;

Shapes one(Shape s) {
  Shapes shapes;
  shapes.shapes.push_back(std::move(s));
  return shapes;
}

Mesh cube(const Vec3& corner = Vec3::Zero()) {
  Mesh m = box_mesh({1, 1, 1});
  transform(m, Mat3::Identity(), corner);
  return m;
}

void append(Mesh& m, const Mesh& other, bool inside_out = false) {
  const auto first = static_cast<std::int32_t>(m.vertices.size());
  m.vertices.insert(m.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (Triangle t : other.triangles) {
    if (inside_out) std::swap(t[1], t[2]);
    m.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

double mean_area(const KMatrix::Entry& e) { return mean_relative_area(e.cdf) * e.max_section_area; }

TEST(KMatrix, LastColumnOfCubeAndOctahedron) {
  const std::array<double, 10> cube_column{.057996, .058463, .060121, .063715, .069843,
                                           .078818, .090664, .107555, .28648,  .12634};
  const std::array<double, 10> octahedron_column{.06841, .06853, .06903, .07033, .07326,
                                                 .07984, .09798, .20525, .25655, .01082};
  const auto check = [](const Mesh& mesh, const std::array<double, 10>& column) {
    const KMatrix k = make_kmatrix(one(measure_shape("solid", mesh)), {.averaging = "upper_edge"});
    EXPECT_LE(k.residual, 1e-3);
    for (int i = 0; i < 10; ++i) EXPECT_NEAR(k.shapes[0].K(i, 9) / column[i], 1, 1e-3) << i;
  };
  check(cube(), cube_column);
  check(platonic_mesh(SolidKind::Octahedron), octahedron_column);
}

TEST(KMatrix, SpheresMeetThePaperAndSaltykov) {
  const Shape ball = measure_shape("ball", ellipsoid_mesh(Vec3::Ones(), 3));
  const KMatrix k = make_kmatrix(one(ball), {.method = kmatrix::Method::Analytic, .averaging = "upper_edge"});
  const auto& e = k.shapes[0];
  for (int j = 1; j <= 10; ++j)
    for (int i = 1; i <= 10; ++i) {
      const double paper =
          j >= i ? (std::sqrt(j * j - (i - 1) * (i - 1)) - std::sqrt(j * j - i * i)) / 10 : 0;
      EXPECT_NEAR(e.K(i - 1, j - 1), paper, 1e-12);
    }
  const Eigen::MatrixXd inverse = (10 * e.K).inverse();
  const std::array<double, 5> saltykov{1, -.1547, -.0357, -.0130, -.0061};
  for (int d = 0; d < 5; ++d) EXPECT_NEAR(inverse(0, d), saltykov[d], 5.1e-5) << d;
  EXPECT_NEAR(e.mean_caliper, std::cbrt(6 * ball.volume / pi), 1e-12);
  // E[A²] of a sphere of diameter 1.
  double second = 0;
  for (std::size_t b = 0; b < e.cdf.size(); ++b) {
    const double s = (static_cast<double>(b) + 0.5) / static_cast<double>(e.cdf.size());
    second += (e.cdf[b] - (b > 0 ? e.cdf[b - 1] : 0)) * std::pow(s, 4);
  }
  EXPECT_NEAR(second, 8.0 / 15, 1e-4);
}

TEST(KMatrix, CalipersOfEllipsoids) {
  EXPECT_NEAR(ellipsoid_statistics({1, 1, 1}).mean_caliper, 2, 1e-12);
  EXPECT_NEAR(ellipsoid_statistics({1, 2, 1}).mean_caliper, 2.7603460, 3e-6);
  EXPECT_NEAR(ellipsoid_statistics({2, 2, 1}).mean_caliper, 3.4183992, 3e-6);
  EXPECT_NEAR(ellipsoid_statistics({.6, 1, .8}).mean_caliper, 1.6200600, 3e-6);
  EXPECT_NEAR(ellipsoid_statistics({.6, 1, .8}).max_section_area, pi * .8, 1e-12);
}

TEST(KMatrix, SlicingAgreesWithTheClosedForm) {
  const Shapes shapes = one(measure_shape("ellipsoid", ellipsoid_mesh({1, .8, .6}, 4)));
  const KMatrix slice = make_kmatrix(shapes, {.orientations = 1000});
  const KMatrix exact = make_kmatrix(shapes, {.method = kmatrix::Method::Analytic});
  // The first class is sensitive to the facets, whose corners have more small sections than a smooth pole.
  for (int i = 1; i < 10; ++i) EXPECT_NEAR(slice.shapes[0].K(i, 9) / exact.shapes[0].K(i, 9), 1, 1e-2) << i;
}

TEST(KMatrix, IdentitiesOfRandomSections) {
  for (const SolidKind kind : {SolidKind::Tetrahedron, SolidKind::Dodecahedron, SolidKind::Icosahedron}) {
    const Shape s = measure_shape("solid", platonic_mesh(kind));
    for (const char* averaging : {"uniform", "upper_edge"}) {
      const KMatrix k = make_kmatrix(one(s), {.classes = 7, .averaging = averaging, .orientations = 1000});
      const auto& e = k.shapes[0];
      EXPECT_EQ(e.profiles_per_caliper, 1);
      EXPECT_NEAR(mean_area(e) / (s.volume / s.mean_caliper), 1, 1e-3) << static_cast<int>(kind);
      for (int j = 0; j < 7; ++j) {
        const double sum = std::string(averaging) == "uniform" ? (j + 0.5) / 7 : (j + 1.0) / 7;
        EXPECT_NEAR(e.K.col(j).sum(), sum, 1e-9);
        for (int i = j + 1; i < 7; ++i) EXPECT_NEAR(e.K(i, j), 0, 1e-12);
      }
    }
  }
}

TEST(KMatrix, UniformIsTheMeanOfUpperEdgesWithinAClass) {
  const KMatrix fine = make_kmatrix(one(measure_shape("cube", cube())),
                                    {.classes = 100, .averaging = "upper_edge", .orientations = 1000});
  const KMatrix coarse =
      make_kmatrix(one(measure_shape("cube", cube())), {.classes = 10, .orientations = 1000});
  for (int j = 0; j < 10; ++j)
    for (int i = 0; i <= j; ++i) {
      // Column means of ten finer classes, each at its upper edge, which is half a fine class too large.
      double mean = 0;
      for (int a = 0; a < 10; ++a)
        for (int b = 0; b < 10; ++b) mean += fine.shapes[0].K(10 * i + b, 10 * j + a) / 10;
      EXPECT_NEAR(mean, coarse.shapes[0].K(i, j), 0.012) << i << " " << j;
    }
}

TEST(KMatrix, DisjointProfilesCountApart) {
  Mesh pair = cube();
  append(pair, cube({1.5, 0, 0}));
  const Shape s = measure_shape("pair", pair);
  const KMatrix k = make_kmatrix(one(s), {.orientations = 4000});
  const auto& e = k.shapes[0];
  EXPECT_GT(e.profiles_per_caliper, 1);
  EXPECT_NEAR(e.profiles_per_caliper * s.mean_caliper, 2 * 1.5, 2e-3);  // each cube separately
  EXPECT_NEAR(mean_area(e), 2.0 / 3, 2e-3);                             // V/H̄ of one cube
}

TEST(KMatrix, HolesAreTakenOff) {
  Mesh hollow = cube();
  Mesh inner = cube();
  transform(inner, 0.5 * Mat3::Identity(), Vec3::Zero());
  append(hollow, inner, true);
  const Shape s = measure_shape("hollow", hollow);
  EXPECT_NEAR(s.volume, 1 - 0.125, 1e-12);
  const KMatrix k = make_kmatrix(one(s), {.orientations = 2000});
  const auto& e = k.shapes[0];
  EXPECT_NEAR(e.profiles_per_caliper, 1, 2e-3);
  EXPECT_NEAR(mean_area(e), s.volume / 1.5, 1e-3);
}

TEST(KMatrix, ProbabilitiesAreNormalized) {
  Shapes shapes = one(measure_shape("cube", cube(), 3));
  shapes.shapes.push_back(measure_shape("tetrahedron", platonic_mesh(SolidKind::Tetrahedron), 1));
  const KMatrix k = make_kmatrix(shapes, {.orientations = 16});
  EXPECT_DOUBLE_EQ(k.shapes[0].probability, 0.75);
  EXPECT_DOUBLE_EQ(k.shapes[1].probability, 0.25);
  // The node warns about the normalization.
  const auto warnings = [](const Shapes& s) {
    return test::run_node("KMatrix", {{"shapes", Value::of(s)}}, {{"orientations", "16"}}).warnings.size();
  };
  EXPECT_EQ(warnings(shapes), 1u);
  shapes.shapes[0].probability = 0.75;
  shapes.shapes[1].probability = 0.25;
  EXPECT_EQ(warnings(shapes), 0u);
}

TEST(KMatrix, RefusesWhatItCannotCut) {
  const auto code = [](const Shapes& s, const KMatrixOptions& o = {}) {
    return test::code_of([&] { make_kmatrix(s, o); });
  };
  EXPECT_EQ(code({}), "no-shapes");
  const Shape good = measure_shape("cube", cube());
  EXPECT_EQ(code(one(good), {.method = kmatrix::Method::Analytic}), "not-an-ellipsoid");
  EXPECT_EQ(code(one(measure_shape("d", platonic_mesh(SolidKind::Icosahedron))),
                 {.method = kmatrix::Method::Analytic}),
            "not-an-ellipsoid");
  Shape bad = good;
  bad.probability = -1;
  EXPECT_EQ(code(one(bad)), "bad-probabilities");
  bad.probability = 0;
  EXPECT_EQ(code(one(bad)), "bad-probabilities");
  bad = good;
  bad.max_section_area = 0;
  EXPECT_EQ(code(one(bad)), "unmeasured-shape");
  bad = good;
  bad.volume = std::nan("");
  EXPECT_EQ(code(one(bad)), "unmeasured-shape");
}

TEST(KMatrix, StopsWhenCancelled) {
  const std::atomic<bool> cancel{true};
  EXPECT_THROW(make_kmatrix(one(measure_shape("cube", cube())), {}, Work(&cancel, nullptr)), Cancelled);
}

TEST(KMatrix, SameBitsOnAnyNumberOfThreads) {
  Mesh pair = cube();
  append(pair, cube({1.5, 0.4, 0.2}));
  Shapes shapes = one(measure_shape("pair", pair));
  shapes.shapes.push_back(measure_shape("cube", cube()));
  const Value value = Value::of(shapes);
  const auto at = [&](int threads) {
    const KMatrix k = test::run_node("KMatrix", {{"shapes", value}}, {{"orientations", "500"}}, {}, threads)
                          .output<KMatrix>("kmatrix");
    return std::array{k.shapes[0].cdf, k.shapes[1].cdf};
  };
  EXPECT_EQ(at(1), at(3));
}

}  // namespace
}  // namespace terrazzo

// The methods of 2008 other than the morphed cylinder.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/common/geometry/mesh/mesh_section.h"
#include "nodes/shapes/shape_estimate/methods/extrusions.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/methods/morph_frame.h"
#include "nodes/shapes/shape_estimate/methods/spherical_harmonics.h"
#include "nodes/shapes/shape_estimate/self_intersections.h"
#include "nodes/shapes/shape_estimate/silhouettes.h"
#include "tests/nodes/shapes/shape_estimate/euler.h"
#include "tests/nodes/shapes/shape_estimate/synthetic_profiles.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace shape_estimate;
namespace made = shape_estimate::test;

using made::Contour;
using std::numbers::pi;

EstimateRequest outlines_of(const std::vector<Contour>& contours, int subdivision = 2) {
  EstimateRequest r;
  r.subdivision = subdivision;
  r.chosen = made::outlines_of(contours, 30);
  return r;
}

std::vector<Contour> stars(std::uint64_t seed, double amplitude, int n = 3) {
  Random r(seed, 6);
  std::vector<Contour> c;
  for (int i = 0; i < n; ++i) c.push_back(made::random_star(r, amplitude));
  return c;
}

TEST(ShapeEstimateCsg, RectanglesMakeTheBox) {
  const auto e = csg(outlines_of({made::rectangle(3, 2), made::rectangle(3, 1), made::rectangle(2, 1)}), {});
  EXPECT_NEAR(mesh_volume(e.mesh), 6, 1e-4);
  EXPECT_NEAR(mesh_surface_area(e.mesh), 22, 1e-3);
  EXPECT_LT(e.deviation, 0.001);
}

// Steinmetz: the intersection of three equal cylinders has the volume 8(2 − √2) r³.
TEST(ShapeEstimateCsg, ThreeCylindersMakeSteinmetzSolid) {
  Polygon circle = made::ellipse(1, 1, 120, {0, 0}, 0.013);
  const Mesh m = intersect_extrusions({circle, circle, circle});
  EXPECT_TRUE(mesh_faults(m).empty());
  EXPECT_EQ(terrazzo::test::euler(m), 2);
  EXPECT_NEAR(mesh_volume(m) / (8 * (2 - std::numbers::sqrt2)), 1, 0.003);
}

// Convex or not, the intersection is closed, and its volume is that of the points in all three extrusions.
TEST(ShapeEstimateCsg, TheIntersectionIsExact) {
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE(seed);
    Random r(seed, 9);
    std::array<Polygon, 3> p;
    for (auto& q : p) q = seed % 3 == 2 ? made::banana(3, 1.2, 1.5, 60) : made::random_star(r, 0.8, 40);
    const Mesh m = intersect_extrusions(p);
    if (m.triangles.empty()) continue;
    EXPECT_TRUE(mesh_faults(m).empty());
    EXPECT_LE(self_intersections(m), 4);  // slivers of randomly perturbed polygons may touch
    // No vertex is outside any of the three polygons or off all of their outlines.
    for (std::size_t v = 0; v < m.vertices.size(); v += 7) {
      double nearest = 1e9;
      for (int k = 0; k < 3; ++k) {
        const Vec2 q(m.vertices[v][k], m.vertices[v][(k + 1) % 3]);
        double away = 1e9;
        for (std::size_t i = 0; i < p[k].size(); ++i) {
          const Vec2 a = p[k][i], d = p[k][(i + 1) % p[k].size()] - a;
          away = std::min(away, (q - a - std::clamp((q - a).dot(d) / d.squaredNorm(), 0.0, 1.0) * d).norm());
        }
        EXPECT_TRUE(away < 1e-5 || loop_contains(p[k], q));
        nearest = std::min(nearest, away);
      }
      EXPECT_LT(nearest, 1e-5);
    }
    if (terrazzo::test::euler(m) != 2) continue;
    // Sampled volume. Only if there is one piece, because smaller pieces would be missing from the mesh.
    int inside = 0;
    constexpr int kSamples = 30000;
    for (int i = 0; i < kSamples; ++i) {
      Random s(seed, 10, static_cast<std::uint64_t>(i));
      const Vec3 x(s.uniform(-4, 4), s.uniform(-4, 4), s.uniform(-4, 4));
      bool in = true;
      for (int k = 0; in && k < 3; ++k) in = loop_contains(p[k], {x[k], x[(k + 1) % 3]});
      inside += in;
    }
    const double volume = 512.0 * inside / kSamples, error = 512 * std::sqrt(inside + 1.0) / kSamples;
    EXPECT_LT(mesh_volume(m), volume + 4.5 * error);
    if (seed % 3 != 2) {
      EXPECT_GT(mesh_volume(m), volume - 4.5 * error);
    }
  }
}

// Viewed along an axis, the body shows the polygon: every triangle is inside it, and every point of the
// outline is near a triangle.
TEST(ShapeEstimateCsg, SilhouettesGiveTheProfilesBack) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const auto request = outlines_of(stars(seed, 0.2), 3);
    const auto e = csg(request, {});
    EXPECT_LT(e.deviation, 0.01);
    const auto polygons = silhouettes_of(request.chosen);
    for (int k = 0; k < 3; ++k) {
      double diameter = 0;
      for (const auto& a : polygons[k])
        for (const auto& b : polygons[k]) diameter = std::max(diameter, (a - b).norm());
      // Points of the outline, moved inwards by a hundredth of the diameter, are covered.
      int covered = 0, all = 0;
      for (std::size_t i = 0; i < polygons[k].size(); i += 8, ++all) {
        const Vec2 q = polygons[k][i] * (1 - 0.01 * diameter / polygons[k][i].norm());
        for (const auto& t : e.mesh.triangles) {
          const auto at = [&](int c) {
            return Vec2(e.mesh.vertices[t[c]][k], e.mesh.vertices[t[c]][(k + 1) % 3]);
          };
          const auto side = [&](const Vec2& a, const Vec2& b) {
            return (b - a).x() * (q - a).y() - (b - a).y() * (q - a).x();
          };
          const double x = side(at(0), at(1)), y = side(at(1), at(2)), z = side(at(2), at(0));
          if ((x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0)) {
            ++covered;
            break;
          }
        }
      }
      EXPECT_EQ(covered, all);
    }
    EXPECT_EQ(terrazzo::test::euler(e.mesh), 2);
  }
}

TEST(ShapeEstimateCsg, PermutationsDiffer) {
  const auto request = outlines_of(stars(3, 0.3));
  auto other = request;
  other.base = 4;
  EXPECT_GT(std::abs(mesh_volume(csg(request, {}).mesh) - mesh_volume(csg(other, {}).mesh)), 1e-6);
}

TEST(ShapeEstimateCylinder, ACircleSweptRoundACircleIsASphere) {
  const auto c = made::ellipse(1, 1);
  const auto e = generalized_cylinder(outlines_of({c, c}), {});
  EXPECT_NEAR(mesh_volume(e.mesh) / (4 * pi / 3), 1, 0.01);
}

TEST(ShapeEstimateCylinder, ARectangleSweptRoundASquareIsABox) {
  const auto e = generalized_cylinder(outlines_of({made::rectangle(2, 2), made::rectangle(2, 1)}), {});
  EXPECT_NEAR(mesh_volume(e.mesh), 4, 0.05);
}

// The base and half of the sweep curve are sections of the shape, star-shaped or not.
TEST(ShapeEstimateCylinder, SectionsGiveTheProfilesBack) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    auto contours = stars(seed, 0.2, 2);
    const auto request = outlines_of(contours, 3);
    const auto e = generalized_cylinder(request, {});
    EXPECT_TRUE(mesh_faults(e.mesh).empty());
    EXPECT_EQ(terrazzo::test::euler(e.mesh), 2);
    EXPECT_LT(frame_deviation(cylinder_frame(request.chosen, "auto"), e.mesh), 0.01);
  }
  const auto e = generalized_cylinder(outlines_of({made::ellipse(1, 0.9), made::banana(4, 1, 2)}), {});
  EXPECT_TRUE(mesh_faults(e.mesh).empty());
  EXPECT_EQ(terrazzo::test::euler(e.mesh), 2);
}

// Extents of the body along its own axes, decreasing. Both methods align them with the base's axes.
// The extents of the mesh are these, which decrease.
void expect_extents(const Mesh& m, const std::array<double, 3>& wanted) {
  Vec3 low = m.vertices[0], high = m.vertices[0];
  for (const auto& v : m.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  std::array<double, 3> e{high.x() - low.x(), high.y() - low.y(), high.z() - low.z()};
  std::sort(e.begin(), e.end(), std::greater<>());
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(e[k] / wanted[k], 1, 0.02);
}

// Flat, elongated and in between, decreasing.
constexpr std::array<std::array<double, 3>, 4> kBodies{{{5, 4, 2}, {5, 2.5, 2}, {9, 6, 4}, {3, 1.2, 1}}};

// From the three principal sections of an ellipsoid or a box, the generalized cylinder has the body's
// extents, whichever two of them it uses.
TEST(ShapeEstimateCylinder, PrincipalSectionsKeepTheBodysExtents) {
  for (const auto& [a, b, c] : kBodies)
    for (const bool box : {false, true})
      for (int base = 0; base < 3; ++base) {
        SCOPED_TRACE(fmt::format("{} × {} × {}, {}, base {}", a, b, c, box ? "box" : "ellipsoid", base));
        const auto section = [&](double x, double y) {
          return box ? made::rectangle(x, y) : made::ellipse(x / 2, y / 2);
        };
        auto request = outlines_of({section(a, b), section(b, c), section(a, c)});
        request.base = base;
        expect_extents(generalized_cylinder(request, {}).mesh, {a, b, c});
      }
}

// The morphed cylinder likewise, on the rounder two of the profiles. The longest cannot be its base without
// scaling, because one of the others would have to lie and the other to stand upright.
TEST(ShapeEstimateCylinder, MorphedCylindersKeepTheBodysExtents) {
  for (const auto& [a, b, c] : kBodies)
    for (int base = 0; base < 2; ++base) {
      SCOPED_TRACE(fmt::format("{} × {} × {}, base {}", a, b, c, base));
      auto request = outlines_of(
          {made::ellipse(a / 2, b / 2), made::ellipse(b / 2, c / 2), made::ellipse(a / 2, c / 2)});
      request.base = base;
      expect_extents(morphed_generalized_cylinder(request, {}).mesh, {a, b, c});
    }
}

// Vertices of the direct tessellation are points of equation 1 of 2008, evaluated here at equal arc lengths.
TEST(ShapeEstimateCylinder, DirectTessellationIsEquation1) {
  auto request = outlines_of(stars(2, 0.3));
  request.tessellation = Tessellation::Direct;
  const MorphFrame f = morph_frame(request.chosen, "auto");
  const auto e = morphed_generalized_cylinder(request, {});
  EXPECT_EQ(mesh_faults(e.mesh), std::vector<std::string>{});
  EXPECT_EQ(terrazzo::test::euler(e.mesh), 2);
  for (std::size_t j = 0; j < f.base.size(); ++j)
    for (const double t_b : {0.0, 0.25, 0.5, 0.75})
      for (const double t_m : {0.25, 0.5, 0.75, 1.0})
        for (const auto* arcs : {&f.upper, &f.lower}) {
          const Arc &m0 = (*arcs)[j], &m1 = (*arcs)[(j + 1) % arcs->size()];
          const Vec2 m = (1 - t_b) * m0.at(t_m) + t_b * m1.at(t_m);
          const Vec2 b = f.base[j].at(t_b) * m.x() / ((1 - t_b) * m0.at(1) + t_b * m1.at(1)).norm();
          double nearest = 1e9;
          for (const auto& v : e.mesh.vertices)
            nearest = std::min(nearest, (v - Vec3(b.x(), b.y(), m.y())).norm());
          EXPECT_LT(nearest, 1e-12);
        }
}

// Both cylinders hold their profiles the better, the finer they are.
TEST(ShapeEstimateCylinder, DirectTessellationConverges) {
  for (const auto& run : {generalized_cylinder, morphed_generalized_cylinder}) {
    double last = 1;
    for (int subdivision = 1; subdivision <= 4; ++subdivision) {
      auto request = outlines_of(stars(4, 0.2), subdivision);
      request.tessellation = Tessellation::Direct;
      const double deviation = run(request, {}).deviation;
      EXPECT_LT(deviation, 0.6 * last) << subdivision;
      last = deviation;
    }
    EXPECT_LT(last, 1e-3);
  }
}

TEST(ShapeEstimateHarmonics, CirclesMakeASphere) {
  const auto c = made::ellipse(2, 2);
  const auto e = spherical_harmonics(outlines_of({c}), {});
  for (const auto& v : e.mesh.vertices) EXPECT_NEAR(v.norm(), 2, 0.02);
}

TEST(ShapeEstimateHarmonics, WeightsAreThoseOfThePaper) {
  // (2n+1)/2 (n−m)!/(n+m)! P_n^m(0)²: P₂²(0) = 3, P₂⁰(0) = −½, P₃³(0) = 15 up to sign.
  EXPECT_NEAR(equator_weights(2, 4)[2], 2.5 / 24 * 9, 1e-12);
  EXPECT_NEAR(equator_weights(3, 4)[3], 3.5 / 720 * 225, 1e-12);
  EXPECT_NEAR(equator_weights(2, 4)[3], 0, 1e-12);  // odd about the equator
}

TEST(ShapeEstimateHarmonics, VariancesComeBack) {
  // λ → κ → λ, if no κ requires a negative λ.
  std::vector<double> lambda(31, 0), kappa(31, 0);
  for (int n = 2; n <= 30; ++n) lambda[n] = 0.2 / std::pow(n, 3);
  for (int m = 2; m <= 30; ++m) {
    const auto w = equator_weights(m, 30);
    for (int n = m; n <= 30; ++n) kappa[m] += w[n] * lambda[n];
  }
  const auto back = harmonic_variances(kappa);
  for (int n = 2; n <= 30; ++n) EXPECT_NEAR(back[n] / lambda[n], 1, 1e-4) << n;
}

// Central sections of many particles have the spectrum of the profiles.
TEST(ShapeEstimateHarmonics, SectionsHaveTheProfilesSpectrum) {
  const auto request = outlines_of(stars(2, 0.25, 12), 0);
  const auto want = profile_spectrum(request.chosen, kHarmonicTerms);
  std::vector<Outline> sections;
  for (int i = 0; i < 24; ++i) {
    auto r = request;
    r.index = i;
    const auto e = spherical_harmonics(r, {});
    const Mat3 frame = Quat(Random(1, 2, i).normal(), 1, 0.5, 0.3).normalized().toRotationMatrix();
    for (const auto& profile : section_profiles(section_loops(e.mesh, frame, 0)))
      sections.push_back(make_outline(i + 1, profile[0], 30));
  }
  const auto got = profile_spectrum(sections, kHarmonicTerms);
  EXPECT_NEAR(got.radius / want.radius, 1, 0.1);
  for (int m = 2; m <= 4; ++m) EXPECT_NEAR(got.variance[m] / want.variance[m], 1, 0.6) << m;
}

TEST(ShapeEstimateHarmonics, ParticlesDiffer) {
  auto a = outlines_of(stars(1, 0.3)), b = a;
  b.index = 1;
  EXPECT_NE(mesh_volume(spherical_harmonics(a, {}).mesh), mesh_volume(spherical_harmonics(b, {}).mesh));
}

TEST(ShapeEstimateMethods, EachRunsInTheNode) {
  Random r(11);
  std::vector<Contour> contours;
  for (int i = 0; i < 20; ++i) contours.push_back(made::random_star(r, 0.2));
  const Value profiles = Value::of(made::profiles_of(contours));
  for (const auto& m : estimate_methods()) {
    SCOPED_TRACE(m.name);
    if (!m.run) continue;
    const auto run = terrazzo::test::run_node("ShapeEstimate", {{"profiles", profiles}},
                                              {{"method", m.name}, {"count", "2"}, {"subdivision", "0"}});
    const auto& shapes = run.output<Shapes>("shapes").shapes;
    ASSERT_EQ(shapes.size(), 2u);
    for (const auto& s : shapes) {
      EXPECT_TRUE(mesh_faults(s.mesh).empty());
      EXPECT_EQ(terrazzo::test::euler(s.mesh), 2);
      EXPECT_GT(s.volume, 0.5);
      EXPECT_LT(s.volume, 20);
    }
    EXPECT_NE(shapes[0].volume, shapes[1].volume);
    // Two ids are too few for three profiles.
    EXPECT_EQ(terrazzo::test::code_of([&] {
                terrazzo::test::run_node("ShapeEstimate", {{"profiles", profiles}},
                                         {{"method", m.name}, {"count", "1"}, {"profiles", "[1, 2]"}});
              }),
              m.least > 2 ? "too-few-profiles" : "");
  }
}

}  // namespace
}  // namespace terrazzo

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/data/profiles.h"
#include "nodes/data/shapes.h"
#include "nodes/shapes/shape_estimate/choose.h"
#include "nodes/shapes/shape_estimate/methods/method.h"
#include "nodes/shapes/shape_estimate/methods/morph_frame.h"
#include "nodes/shapes/shape_estimate/self_intersections.h"
#include "nodes/shapes/shape_estimate/subdivide.h"
#include "tests/nodes/shapes/shape_estimate/euler.h"
#include "tests/nodes/shapes/shape_estimate/synthetic_profiles.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using namespace shape_estimate;
namespace made = shape_estimate::test;

using made::Contour;
using std::numbers::pi;

EstimateRequest request_of(const std::vector<Contour>& contours, int subdivision, int control = 0,
                           const std::string& axis = "short") {
  EstimateRequest r;
  r.subdivision = subdivision;
  r.control = control;
  r.axis = axis;
  r.chosen = made::outlines_of(contours, 40);
  return r;
}

Estimate morph(const EstimateRequest& r) { return morphed_generalized_cylinder(r, Work()); }

TEST(ShapeEstimateMorph, CirclesMakeASphere) {
  const auto c = made::ellipse(1, 1);
  const auto e = morph(request_of({c, c, c}, 2, 4));
  EXPECT_NEAR(mesh_volume(e.mesh) / (4 * pi / 3), 1, 0.01);
  EXPECT_NEAR(mesh_surface_area(e.mesh) / (4 * pi), 1, 0.01);
  EXPECT_TRUE(e.smooth);
  for (const auto& v : e.mesh.vertices) EXPECT_NEAR(v.norm(), 1, 0.01);
}

TEST(ShapeEstimateMorph, PrincipalSectionsMakeTheEllipsoid) {
  // Semi-axes 2, 1.6, 1.2.
  const auto e =
      morph(request_of({made::ellipse(2, 1.2), made::ellipse(2, 1.6), made::ellipse(1.6, 1.2)}, 2, 5));
  EXPECT_NEAR(mesh_volume(e.mesh) / (4 * pi / 3 * 2 * 1.6 * 1.2), 1, 0.02);
}

TEST(ShapeEstimateMorph, UprightProfilesMakeTheLongBody) {
  // A circle and two 2:1 ellipses are sections of both an oblate and a prolate spheroid.
  const std::vector<Contour> c{made::ellipse(1, 1), made::ellipse(2, 1), made::ellipse(2, 1)};
  EXPECT_NEAR(mesh_volume(morph(request_of(c, 2, 5, "short")).mesh) / (4 * pi / 3 * 0.5), 1, 0.02);
  EXPECT_NEAR(mesh_volume(morph(request_of(c, 2, 5, "long")).mesh) / (4 * pi / 3 * 2), 1, 0.02);
}

TEST(ShapeEstimateMorph, RectanglesMakeTheBox) {
  const auto e =
      morph(request_of({made::rectangle(3, 2), made::rectangle(3, 1), made::rectangle(2, 1)}, 2, 4));
  EXPECT_NEAR(mesh_volume(e.mesh), 6, 1e-6);
  EXPECT_NEAR(mesh_surface_area(e.mesh), 22, 1e-6);
  EXPECT_FALSE(e.smooth);
}

TEST(ShapeEstimateMorph, TheFrameMeetsItsConstraintsExactly) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random r(seed);
    std::vector<Outline> profiles;
    const int n = 3 + static_cast<int>(seed % 3);
    for (int i = 0; i < n; ++i) profiles.push_back(make_outline(i + 1, made::random_star(r, 0.4), 40));
    const auto frame = morph_frame(profiles, seed % 2 ? "long" : "short", static_cast<int>(seed) % n);
    ASSERT_EQ(frame.radius.size(), 2u * (n - 1));
    const Vec2 top = frame.upper[0].points.front(), bottom = frame.lower[0].points.front();
    for (std::size_t j = 0; j < frame.radius.size(); ++j) {
      EXPECT_LT((frame.upper[j].points.front() - top).norm(), 1e-12);
      EXPECT_LT((frame.lower[j].points.front() - bottom).norm(), 1e-12);
      EXPECT_LT((frame.upper[j].points.back() - Vec2(frame.radius[j], 0)).norm(), 1e-12);
      EXPECT_LT((frame.lower[j].points.back() - Vec2(frame.radius[j], 0)).norm(), 1e-12);
      EXPECT_NEAR(frame.base[j].points.front().norm(), frame.radius[j], 1e-12);
      for (const auto* arc : {&frame.upper[j], &frame.lower[j]})
        for (std::size_t i = 1; i < arc->t.size(); ++i) EXPECT_GE(arc->t[i], arc->t[i - 1]);
    }
    EXPECT_NEAR(top.x(), 0, 1e-12);
    EXPECT_GT(top.y(), 0);
    EXPECT_LT(bottom.y(), 0);
  }
}

// Random outlines, star-shaped and not, always yield a closed surface of genus 0.
TEST(ShapeEstimateMorph, AlwaysWatertightAndOfGenusZero) {
  for (std::uint64_t seed = 0; seed < 36; ++seed) {
    SCOPED_TRACE(seed);
    Random r(seed, 5);
    std::vector<Contour> contours;
    const int n = 3 + static_cast<int>(seed % 4);
    for (int i = 0; i < n; ++i) {
      const double kind = r.uniform();
      if (kind < 0.6)
        contours.push_back(made::random_star(r, 0.5 * r.uniform()));
      else if (kind < 0.8)
        contours.push_back(made::banana(4, 1, 0.5 + 2 * r.uniform()));
      else
        contours.push_back({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}});
    }
    const auto e = morph(
        request_of(contours, static_cast<int>(seed % 3), seed % 5 ? 0 : 4, seed % 2 ? "long" : "short"));
    EXPECT_TRUE(mesh_faults(e.mesh).empty());
    EXPECT_EQ(terrazzo::test::euler(e.mesh), 2);
    EXPECT_GT(mesh_volume(e.mesh), 0);
    EXPECT_GE(e.deviation, 0);
  }
}

TEST(ShapeEstimateMorph, SectionsGiveTheProfilesBack) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(seed);
    Random r(seed, 6);
    std::vector<Contour> contours;
    for (int i = 0; i < 3; ++i) contours.push_back(made::random_star(r, 0.2));
    const auto request = request_of(contours, 3, 0, seed % 2 ? "long" : "short");
    const auto e = morph(request);
    EXPECT_LT(frame_deviation(morph_frame(request.chosen, request.axis), e.mesh), 0.01);
    EXPECT_EQ(frame_deviation(morph_frame(request.chosen, request.axis), e.mesh), e.deviation);
    EXPECT_EQ(self_intersections(e.mesh), 0);
  }
}

TEST(ShapeEstimateMorph, TheFrameCurvesAreTheProfilesScaled) {
  // These profiles fit already: they are scaled by one factor only, so areas keep their ratios.
  const auto request = request_of({made::ellipse(2, 1.2), made::ellipse(2, 1.6), made::ellipse(1.6, 1.2)}, 1);
  const auto frame = morph_frame(request.chosen, "short");
  EXPECT_NEAR(frame.distortion, 1, 1e-3);
  const double want[] = {pi * 2 * 1.6, pi * 2 * 1.2, pi * 1.6 * 1.2};
  const auto curves = frame_curves(frame);
  ASSERT_EQ(curves.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    double area = 0;
    for (std::size_t i = 0; i < curves[k].size(); ++i) {
      const Vec2 &a = curves[k][i], &b = curves[k][(i + 1) % curves[k].size()];
      area += (a.x() * b.y() - a.y() * b.x()) / 2;
    }
    EXPECT_NEAR(area / want[k], 1, 2e-3);
  }
}

TEST(ShapeEstimateSubdivide, PassesThroughItsPoints) {
  ControlMesh cube;
  for (int i = 0; i < 8; ++i) cube.vertices.emplace_back(i & 1, i >> 1 & 1, i >> 2 & 1);
  cube.faces = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const int level : {0, 1, 3}) {
    const Mesh m = interpolating_surface(cube, level, 60);
    EXPECT_TRUE(mesh_faults(m).empty());
    EXPECT_EQ(m.triangles.size(), 12u << (2 * level));
    for (const auto& v : cube.vertices) {
      double nearest = 1;
      for (const auto& p : m.vertices) nearest = std::min(nearest, (p - v).norm());
      EXPECT_LT(nearest, 1e-6);
    }
  }
  // With permanent creases it is the cube itself.
  for (const auto& f : cube.faces)
    for (int k = 0; k < 4; ++k)
      if (f[k] < f[(k + 1) % 4]) {
        cube.crease_edges.push_back({f[k], f[(k + 1) % 4]});
        cube.crease_sharpness.push_back(10);
      }
  EXPECT_NEAR(mesh_volume(interpolating_surface(cube, 2)), 1, 1e-9);
}

TEST(ShapeEstimateSelfIntersections, CountsWhatPassesThrough) {
  const auto c = made::ellipse(1, 1);
  Mesh a = morph(request_of({c, c, c}, 1, 4)).mesh, two = a;
  EXPECT_EQ(self_intersections(a), 0);
  const auto n = static_cast<int>(a.vertices.size());
  for (const auto& v : a.vertices) two.vertices.push_back(v + Vec3(3, 0.1, 0.2));
  for (const auto& t : a.triangles) two.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  EXPECT_EQ(self_intersections(two), 0);
  for (int i = n; i < 2 * n; ++i) two.vertices[i].x() -= 2;
  // The seam of two unit spheres at unit distance is a circle of some fifty triangles on each.
  EXPECT_GT(self_intersections(two), 30);
  EXPECT_LT(self_intersections(two), 400);
}

TEST(ShapeEstimateChoose, LeavesOutWhatHasNoShape) {
  std::vector<Contour> contours;
  for (int i = 0; i < 20; ++i) contours.push_back(made::ellipse(10, 8, 60));
  contours.push_back(made::pixelated(made::ellipse(2, 2), 1));  // 12 pixels
  Contour limacon;                                              // has an inner loop
  for (int i = 0; i < 80; ++i) {
    const double t = 2 * pi * i / 80, radius = 4 + 7 * std::cos(t);
    limacon.push_back({radius * std::cos(t), radius * std::sin(t)});
  }
  contours.push_back(limacon);
  contours.push_back({});
  auto p = made::profiles_of(contours);
  p.profiles[3].touches_border = true;
  p.profiles[4].cls = 1;
  const auto c = candidates_of(p, {.cls = 0});
  EXPECT_EQ(c.outlines.size(), 18u);
  EXPECT_EQ(c.too_small, 1);
  EXPECT_EQ(c.faulty, 1);
  EXPECT_EQ(c.without_contour, 1);
  EXPECT_EQ(c.cut_by_border, 1);
  EXPECT_EQ(c.other_class, 1);
  EXPECT_NE(c.text().find("1 cut by the border"), std::string::npos);
}

TEST(ShapeEstimateChoose, RulesChooseWhatTheySay) {
  Random r(4);
  std::vector<Outline> outlines;
  for (int i = 0; i < 60; ++i)
    outlines.push_back(
        make_outline(i + 1, made::ellipse(20 - 0.1 * i, (20 - 0.1 * i) * r.uniform(0.7, 0.9)), 40));
  outlines[50] = make_outline(51, made::rectangle(40, 3), 40);
  for (const char* rule : {"largest", "representative", "diverse"}) {
    SCOPED_TRACE(rule);
    const auto hands = choose_profiles(outlines, rule, 4, 3, 1);
    ASSERT_EQ(hands.size(), 4u);
    std::set<int> all;
    for (const auto& h : hands) {
      EXPECT_EQ(h.size(), 3u);
      all.insert(h.begin(), h.end());
    }
    EXPECT_EQ(all.size(), 12u);
    if (std::string(rule) == "largest") {
      EXPECT_EQ(*all.rbegin(), 11);
    }
    EXPECT_EQ(all.count(50), std::string(rule) == "diverse" ? 1u : 0u);
    EXPECT_EQ(choose_profiles(outlines, rule, 4, 3, 1), hands);
  }
  EXPECT_NE(choose_profiles(outlines, "representative", 4, 3, 1),
            choose_profiles(outlines, "representative", 4, 3, 2));
  // Fewer profiles than needed: none is used twice in one shape if there is another.
  outlines.resize(4);
  for (const auto& h : choose_profiles(outlines, "largest", 5, 3, 1))
    EXPECT_EQ(std::set<int>(h.begin(), h.end()).size(), 3u);
}

// Sizes from 20 down to 2, a third of them merged with a neighbor, so that they are not convex: each group of
// sizes gives one that is not, and large ones, which cover most, give more than small ones.
TEST(ShapeEstimateChoose, EachSizeGivesAUsualOutline) {
  Random r(4);
  std::vector<Outline> outlines;
  for (int i = 0; i < 90; ++i) {
    const double size = 20 - 0.2 * i;
    made::Contour loop = made::ellipse(size, 0.8 * size);
    if (i % 3 == 1)
      for (Vec2& p : loop) p *= 1 - 0.4 * std::exp(-std::pow(p.x() / (0.2 * size), 2));
    outlines.push_back(make_outline(i + 1, loop, 40));
  }
  const auto hands = choose_profiles(outlines, "each_size", 12, 1, 1);
  ASSERT_EQ(hands.size(), 12u);
  std::set<int> chosen;
  for (const auto& hand : hands) chosen.insert(hand.at(0));
  EXPECT_EQ(chosen.size(), 12u);
  int large = 0;
  for (const int i : chosen) {
    EXPECT_NE(i % 3, 1) << i;
    large += i < 45;
  }
  EXPECT_GE(large, 9);
  EXPECT_LE(large, 11);
}

Profiles thirty() {
  Random r(11);
  std::vector<Contour> contours;
  for (int i = 0; i < 30; ++i) contours.push_back(made::random_star(r, 0.2));
  return made::profiles_of(contours);
}

TEST(ShapeEstimateNode, MakesShapesOfModerateSize) {
  const auto run = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of(thirty())}});
  const auto& s = run.output<Shapes>("shapes").shapes;
  ASSERT_EQ(s.size(), 3u);
  for (const auto& shape : s) {
    EXPECT_TRUE(mesh_faults(shape.mesh).empty());
    EXPECT_LE(shape.mesh.triangles.size(), 2208u);
    EXPECT_GE(shape.mesh.triangles.size(), 500u);
    EXPECT_NEAR(shape.probability, 1.0 / 3, 1e-12);
    EXPECT_GT(shape.volume, 0.5);
    EXPECT_LT(shape.volume, 10);
  }
  EXPECT_EQ(run.metrics.at("usable_profiles"), 30);
  EXPECT_EQ(run.metrics.at("self_intersections"), 0);
}

TEST(ShapeEstimateNode, RepeatsItselfOnAnyNumberOfThreads) {
  for (const char* rule : {"representative", "diverse"}) {
    const std::map<std::string, std::string> p{
        {"profiles", rule}, {"count", "2"}, {"seed", "5"}, {"axis", "alternate"}};
    const auto a = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of(thirty())}}, p, {}, 1);
    const auto b = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of(thirty())}}, p, {}, 2);
    const auto &x = a.output<Shapes>("shapes").shapes, &y = b.output<Shapes>("shapes").shapes;
    ASSERT_EQ(x.size(), 2u);
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(x[i].name, y[i].name);
      EXPECT_EQ(x[i].mesh.vertices, y[i].mesh.vertices);
      EXPECT_EQ(x[i].mesh.triangles, y[i].mesh.triangles);
    }
    EXPECT_NE(x[0].volume, x[1].volume);
  }
}

TEST(ShapeEstimateNode, TakesProfilesById) {
  const auto run = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of(thirty())}},
                                            {{"profiles", "[4, 9, 2]"}, {"count", "2"}});
  const auto& s = run.output<Shapes>("shapes").shapes;
  ASSERT_EQ(s.size(), 2u);
  EXPECT_EQ(s[0].name, "profiles 4, 9, 2");
  EXPECT_NE(s[0].volume, s[1].volume);  // another base
  const auto more = terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of(thirty())}},
                                             {{"profiles", "[1, 2, 3, 4, 5, 6]"}, {"count", "2"}});
  EXPECT_EQ(more.output<Shapes>("shapes").shapes[1].name, "profiles 4, 5, 6");
  auto cut = thirty();
  cut.profiles[8].touches_border = true;
  const auto warned =
      terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of(cut)}}, {{"profiles", "[4, 9, 2]"}});
  ASSERT_FALSE(warned.warnings.empty());
  EXPECT_NE(warned.warnings[0].find("profile 9"), std::string::npos);
}

TEST(ShapeEstimateNode, SaysWhatIsMissing) {
  const auto refusal = [](Profiles p, const std::map<std::string, std::string>& parameters = {}) {
    try {
      terrazzo::test::run_node("ShapeEstimate", {{"profiles", Value::of(std::move(p))}}, parameters);
    } catch (const Error& e) {
      return e.diagnostic();
    }
    Diagnostic none;
    none.code = "accepted";
    return none;
  };
  EXPECT_EQ(refusal({}).code, "too-few-profiles");
  auto areas = thirty();
  for (auto& p : areas.profiles) p.contour.clear();
  const auto d = refusal(areas);
  EXPECT_EQ(d.code, "too-few-profiles");
  EXPECT_NE(d.hint.find("without outlines"), std::string::npos) << d.hint;
  auto cut = thirty();
  for (std::size_t i = 2; i < 30; ++i) cut.profiles[i].touches_border = true;
  EXPECT_NE(refusal(cut).message.find("28 cut by the border"), std::string::npos);
  EXPECT_EQ(refusal(thirty(), {{"profiles", "[1, 2, 31]"}}).code, "bad-profile");
  EXPECT_NE(refusal(thirty(), {{"profiles", "[0, 1, 2]"}}).code, "accepted");
  EXPECT_EQ(refusal(thirty(), {{"profiles", "[1, 2]"}}).code, "too-few-profiles");
  auto crossed = thirty();
  crossed.profiles[5].contour = {{0, 0}, {1, 1}, {1, 0}, {0, 1.2}};
  const auto bad = refusal(crossed, {{"profiles", "[5, 6, 7]"}});
  EXPECT_EQ(bad.code, "bad-profile");
  EXPECT_NE(bad.message.find("profile 6"), std::string::npos) << bad.message;
  EXPECT_EQ(refusal(thirty(), {{"class", "3"}}).code, "too-few-profiles");
}

}  // namespace
}  // namespace terrazzo

// Tests that packings have no overlap, and how dense they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nodes/packing/rigid/audit.h"
#include "tests/nodes/packing/anneal/packing_support.h"

namespace terrazzo {
namespace {

using test::expect_sound;
using test::pack;
using test::brute::overlaps;

TEST(Anneal, SpheresDoNotOverlap) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto run = pack(shapes, test::distribution(shapes, 1, 2, 0.5), {{"count", "150"}});
  expect_sound(shapes, run, 0.5);
}

// Spheres are packed as the spheres that their meshes represent; corners of facets, which extend
// beyond, are rotated away.
TEST(Anneal, FacetsOfSpheresCostNoDensity) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto run = pack(shapes, test::distribution(shapes, 1, 1.3, 0.62), {{"count", "200"}});
  expect_sound(shapes, run, 0.62);
  const auto& p = run.output<Particles>("particles");
  const double ball = std::cbrt(0.75 / M_PI * shapes.shapes[0].volume);
  int closer = 0;  // pairs closer than their corners would allow
  for (std::size_t i = 0; i < p.count(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      Vec3 d = p.position[i] - p.position[j];
      for (int a = 0; a < 3; ++a) d[a] -= std::round(d[a] / p.box[a]) * p.box[a];
      EXPECT_GE(d.norm(), ball * (p.scale[i] + p.scale[j]));
      closer += d.norm() < p.scale[i] + p.scale[j];
    }
  EXPECT_GT(closer, 50);
}

TEST(Anneal, CubesDoNotOverlap) {
  const auto shapes = test::shapes_of({test::cube()});
  expect_sound(shapes, pack(shapes, test::distribution(shapes, 1, 1.5, 0.45), {{"count", "250"}}), 0.45);
}

TEST(Anneal, TetrahedraDoNotOverlap) {
  const auto shapes = test::shapes_of({test::tetrahedron()});
  expect_sound(shapes, pack(shapes, test::distribution(shapes, 1, 1.5, 0.4), {{"count", "200"}}), 0.4);
}

TEST(Anneal, EllipsoidsDoNotOverlap) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  expect_sound(shapes, pack(shapes, test::distribution(shapes, 1, 2, 0.55), {{"count", "150"}}), 0.55);
}

TEST(Anneal, NonConvexMixturesDoNotOverlap) {
  const auto shapes = test::shapes_of({test::peanut(2), test::angle()});
  const auto run = pack(shapes, test::distribution(shapes, 1, 3, 0.4), {{"count", "150"}});
  expect_sound(shapes, run, 0.4);
  const auto& p = run.output<Particles>("particles");
  const auto first = std::count(p.shape.begin(), p.shape.end(), 0);
  EXPECT_NEAR(static_cast<double>(first) / static_cast<double>(p.count()), 0.5, 0.05);
}

TEST(Anneal, SharpNonConvexShapesDoNotOverlap) {
  const auto shapes = test::shapes_of({test::angle()});
  expect_sound(shapes, pack(shapes, test::distribution(shapes, 1, 2, 0.42), {{"count", "250"}}), 0.42);
}

TEST(Anneal, BinderGapKeepsDistance) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto run =
      pack(shapes, test::distribution(shapes, 1, 1.2, 0.3), {{"count", "150"}, {"binder_gap", "0.1"}});
  const auto& p = run.output<Particles>("particles");
  const double ball = std::cbrt(0.75 / M_PI * shapes.shapes[0].volume);
  double least = 1e300;
  for (std::size_t i = 0; i < p.count(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      Vec3 d = p.position[i] - p.position[j];
      for (int a = 0; a < 3; ++a) d[a] -= std::round(d[a] / p.box[a]) * p.box[a];
      least = std::min(least, d.norm() - ball * (p.scale[i] + p.scale[j]));
    }
  EXPECT_GE(least, 0.1 - 1e-6);
  EXPECT_EQ(packing::audit(shapes, p, 0.1).worst, 0);
}

// Volume fractions that frictionless bodies reach when poured and shaken, but loose packings do not.
TEST(Anneal, PolyhedraPackAsDenseAsShakenDice) {
  const auto reached = [](const Mesh& mesh) {
    const auto shapes = test::shapes_of({mesh});
    const auto run = pack(shapes, test::distribution(shapes, 1, 1.01, 0.8),
                          {{"count", "60"}, {"on_jam", "shrink"}, {"iterations", "900"}});
    EXPECT_EQ(overlaps(shapes, run.output<Particles>("particles")), 0);
    return run.metrics.at("packing_fraction");
  };
  EXPECT_GT(reached(test::cube()), 0.6);
  EXPECT_GT(reached(test::tetrahedron()), 0.54);
}

TEST(Anneal, DenseEllipsoids) {
  const auto ellipsoids = test::shapes_of({test::ellipsoid(2)});
  expect_sound(ellipsoids, pack(ellipsoids, test::distribution(ellipsoids, 1, 1.3, 0.65), {{"count", "100"}}),
               0.65);
}

// Small grains touch large ones in their dents and across their ridges, where surface points chosen for
// flat contacts miss them.
TEST(Anneal, DentedGrainsOfManySizesPackDense) {
  const auto shapes = test::shapes_of({test::warped(test::icosphere(3), [](const Vec3& p) {
    const double r =
        1 + 0.1 * std::sin(5 * p[0] + 1) * std::sin(4 * p[1]) + 0.08 * std::sin(6 * p[2] + 2 * p[0]);
    return Vec3(r * p.cwiseProduct(Vec3(1.2, 1, 0.8)));
  })});
  auto d = test::distribution(shapes, 1, 6, 0.56, 7);
  for (std::size_t k = 0; k < 7; ++k) d.shapes[0].N_V[k] *= std::pow(0.45, k);
  const auto run = pack(shapes, d, {{"size", "10"}});
  EXPECT_GT(run.output<Particles>("particles").count(), 50u);
  EXPECT_NEAR(run.metrics.at("packing_fraction"), 0.56, 0.0056);
  EXPECT_EQ(run.metrics.at("max_penetration"), 0);
  EXPECT_EQ(run.metrics.at("shrink"), 1);
}

TEST(Anneal, PolyhedraKeepTheirDistanceByTheAudit) {
  const auto shapes = test::shapes_of({test::cube(), test::peanut(2)});
  const auto run =
      pack(shapes, test::distribution(shapes, 1, 1.5, 0.3), {{"count", "120"}, {"binder_gap", "0.05"}});
  const auto& p = run.output<Particles>("particles");
  EXPECT_LE(run.metrics.at("max_penetration"), 1e-4);
  EXPECT_LE(packing::audit(shapes, p, 0.05).worst, 1e-4);
  EXPECT_GT(packing::audit(shapes, p, 0.5).worst, 0.01);
}

}  // namespace
}  // namespace terrazzo

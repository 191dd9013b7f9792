#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "graph/diagnostic.h"
#include "nodes/anneal/audit.h"
#include "nodes/anneal/limits.h"
#include "nodes/anneal/packing.h"
#include "nodes/anneal/spatial_order.h"
#include "nodes/anneal/statistics.h"
#include "runtime/codec.h"
#include "runtime/random.h"
#include "tests/nodes/anneal/brute_force.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

using test::run_node;
using test::brute::overlaps;

test::NodeRun pack(const Shapes& shapes, const SizeDistribution& d,
                   std::map<std::string, std::string> parameters, int threads = 2,
                   const Particles* start = nullptr) {
  std::multimap<std::string, Value> inputs{{"shapes", Value::of<Shapes>(shapes)},
                                           {"distribution", Value::of<SizeDistribution>(d)}};
  if (start) inputs.emplace("start", Value::of<Particles>(*start));
  return run_node("Anneal", inputs, parameters, {}, threads);
}

std::vector<char> bytes(const Particles& p) {
  BufferWriter w;
  value_type<Particles>().encode(&p, w);
  return w.buffer;
}

std::string code_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const Error& e) {
    return e.diagnostic().code + ": " + e.diagnostic().message;
  }
  return "no error";
}

void expect_sound(const Shapes& shapes, const test::NodeRun& run, double fraction) {
  const auto& p = run.output<Particles>("particles");
  EXPECT_EQ(run.metrics.at("max_penetration"), 0);
  EXPECT_EQ(overlaps(shapes, p), 0);
  EXPECT_NEAR(run.metrics.at("packing_fraction"), fraction, 0.01 * fraction);
  EXPECT_NEAR(run.metrics.at("packing_fraction"), anneal::volume_fraction(shapes, p), 1e-12);
  for (std::size_t i = 0; i < p.count(); ++i) {
    for (int a = 0; a < 3; ++a) {
      EXPECT_GE(p.position[i][a], 0);
      EXPECT_LT(p.position[i][a], p.box[a]);
    }
    EXPECT_NEAR(p.orientation[i].norm(), 1, 1e-9);
    EXPECT_NEAR(p.scale[i] * shapes.shapes[p.shape[i]].size(), p.size[i], 1e-9);
  }
}

TEST(Anneal, SpheresDoNotOverlap) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto run = pack(shapes, test::distribution(shapes, 1, 2, 0.5), {{"count", "150"}});
  expect_sound(shapes, run, 0.5);
}

// Packed as the spheres that they stand for: corners of facets, which lie beyond, are turned away.
TEST(Anneal, FacetsOfSpheresCostNoDensity) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto run = pack(shapes, test::distribution(shapes, 1, 1.3, 0.62), {{"count", "200"}});
  expect_sound(shapes, run, 0.62);
  const auto& p = run.output<Particles>("particles");
  const double ball = std::cbrt(0.75 / M_PI * shapes.shapes[0].volume);
  int closer = 0;  // than their corners would allow
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

TEST(Anneal, StopsWhenCancelled) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  const std::atomic<bool> cancel{true};
  anneal::PackOptions options;
  options.population.count = 300;
  EXPECT_THROW(anneal::pack_particles(test::distribution(shapes, 1, 2, 0.5), shapes, nullptr, options,
                                      Work(&cancel, nullptr)),
               Cancelled);
}

TEST(Anneal, SizesAreTheRequestedOnes) {
  const auto shapes = test::shapes_of({test::icosphere(2)});
  const auto d = test::distribution(shapes, 1, 3, 0.35, 8);
  const auto run = pack(shapes, d, {{"count", "400"}});
  const auto& sizes = run.output<Table>("sizes");
  const auto& p = run.output<Particles>("particles");
  for (std::size_t k = 0; k < d.classes(); ++k) {
    const double asked = d.shapes[0].N_V[k] * p.box.prod();
    EXPECT_NEAR(sizes.number(k, "requested"), asked, 0.05 * asked);
    const auto in_class = std::count_if(p.size.begin(), p.size.end(), [&](double s) {
      return s >= d.class_edges[k] && s < d.class_edges[k + 1];
    });
    EXPECT_NEAR(static_cast<double>(in_class), asked, 1.0 + 0.05 * asked);
  }
  EXPECT_EQ(run.metrics.at("shrink"), 1);
  EXPECT_EQ(run.metrics.at("dropped"), 0);
}

TEST(Anneal, SameBitsForAnyNumberOfThreads) {
  const auto shapes = test::shapes_of({test::peanut(2), test::cube()});
  const auto d = test::distribution(shapes, 1, 2, 0.45);
  const std::map<std::string, std::string> parameters{{"count", "120"}, {"seed", "7"}};
  const auto one = bytes(pack(shapes, d, parameters, 1).output<Particles>("particles"));
  EXPECT_EQ(one, bytes(pack(shapes, d, parameters, 2).output<Particles>("particles")));
  EXPECT_EQ(one, bytes(pack(shapes, d, parameters, 7).output<Particles>("particles")));
  EXPECT_NE(one, bytes(pack(shapes, d, {{"count", "120"}, {"seed", "8"}}, 1).output<Particles>("particles")));
}

TEST(Anneal, SameBitsOfDenseSpheresForAnyNumberOfThreads) {
  const auto shapes = test::shapes_of({test::icosphere(2)});
  const auto d = test::distribution(shapes, 1, 1.2, 0.58);
  const auto one = bytes(pack(shapes, d, {{"count", "300"}}, 1).output<Particles>("particles"));
  for (const int threads : {2, 7})
    EXPECT_EQ(one, bytes(pack(shapes, d, {{"count", "300"}}, threads).output<Particles>("particles")));
}

TEST(Anneal, SpatialOrderKeepsNeighboursTogether) {
  std::vector<Vec3> points;
  for (std::uint64_t i = 0; i < 4096; ++i) {
    Random r(1, 0, i);
    points.push_back(Vec3(2 * r.uniform(), 3 * r.uniform(), r.uniform()));
  }
  const auto order = anneal::spatial_order(Vec3(2, 3, 1), points);
  auto sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], static_cast<std::int32_t>(i));
  auto moved = points;
  anneal::reorder(moved, order);
  EXPECT_EQ(moved[7], points[static_cast<std::size_t>(order[7])]);
  double step = 0, before = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    step += (moved[i] - moved[i - 1]).cwiseQuotient(Vec3(2, 3, 1)).norm();
    before += (points[i] - points[i - 1]).cwiseQuotient(Vec3(2, 3, 1)).norm();
  }
  EXPECT_LT(step, 0.2 * before);  // a random walk through the points goes .66 at each
}

// Many are placed and kept by where they are; they come out in their own order, the same at any number of
// threads.
TEST(Anneal, ManyComeOutInTheirOrder) {
  const auto shapes = test::shapes_of({test::icosphere(2)});
  const auto d = test::distribution(shapes, 1, 2, 0.2);
  const std::map<std::string, std::string> parameters{{"count", "51000"}};
  const auto run = pack(shapes, d, parameters, 2);
  const auto& p = run.output<Particles>("particles");
  ASSERT_GT(p.count(), 50000u);
  EXPECT_EQ(run.metrics.at("max_penetration"), 0);
  for (std::size_t i = 1; i < p.count(); ++i) ASSERT_GE(p.size[i - 1], p.size[i]);
  // Anywhere: neither in lattice order nor missing from a part of the box.
  std::array<int, 8> octant{};
  for (const Vec3& x : p.position)
    ++octant[(x[0] * 2 > p.box[0]) + 2 * (x[1] * 2 > p.box[1]) + 4 * (x[2] * 2 > p.box[2])];
  for (const int n : octant) EXPECT_NEAR(n, p.count() / 8.0, 400);
  EXPECT_EQ(bytes(p), bytes(pack(shapes, d, parameters, 1).output<Particles>("particles")));
}

// Planes in the seam and planes midway between two seams cut the same numbers, areas and touching pairs.
TEST(Anneal, TheSeamIsAPlaneLikeAnyOther) {
  const auto shapes = test::shapes_of({test::cube()});
  constexpr int runs = 16;
  // Per axis and packing: seam less middle of the particles cut, of their area, of pairs that touch across.
  std::vector<std::array<double, 3>> difference;
  double pairs_seen = 0;
  for (int seed = 1; seed <= runs; ++seed) {
    const auto run = pack(shapes, test::distribution(shapes, 1, 1.3, 0.5),
                          {{"count", "150"}, {"seed", std::to_string(seed)}});
    const auto& p = run.output<Particles>("particles");
    const double near = 1.3;  // centres of touching cubes of size 1 are about this far apart
    for (int axis = 0; axis < 3; ++axis) {
      const double edge = p.box[axis];
      std::array<double, 3> d{};
      for (std::size_t i = 0; i < p.count(); ++i) {
        const Mat3 turn = p.orientation[i].toRotationMatrix();
        const double reach = 0.5 * p.scale[i] * turn.row(axis).cwiseAbs().sum();
        const auto offset = [&](double plane) {
          const double x = p.position[i][axis] - plane;
          return x - edge * std::round(x / edge);
        };
        for (const double sign : {1.0, -1.0}) {
          const double x = offset(sign > 0 ? 0 : edge / 2);
          if (std::abs(x) < reach) d[0] += sign, d[1] += sign * std::sqrt(1 - std::pow(x / reach, 2));
          for (std::size_t j = 0; j < p.count(); ++j) {
            if (i == j) continue;
            Vec3 v = p.position[j] - p.position[i];
            for (int a = 0; a < 3; ++a) v[a] -= p.box[a] * std::round(v[a] / p.box[a]);
            if (v.norm() < near && x < 0 && x + v[axis] >= 0) d[2] += sign, pairs_seen += 1;
          }
        }
      }
      difference.push_back(d);
    }
  }
  EXPECT_GT(pairs_seen, 500);
  for (int k = 0; k < 3; ++k) {
    double mean = 0, square = 0;
    for (const auto& d : difference) mean += d[k] / double(difference.size());
    for (const auto& d : difference) square += (d[k] - mean) * (d[k] - mean);
    const double error = std::sqrt(square / double(difference.size() * (difference.size() - 1)));
    EXPECT_GT(error, 0);
    EXPECT_LT(std::abs(mean), 3.5 * error) << k;
  }
}

TEST(Anneal, MoreThanTheMemoryHoldsIsRefusedBeforeTheWork) {
  const auto shapes = test::shapes_of({test::cube()});
  anneal::PopulationOptions o;
  o.count = 1000;
  const auto population = anneal::populate(test::distribution(shapes, 1, 1.2, 0.3), shapes, nullptr, o);
  const double needed = anneal::memory_needed(population, shapes);
  EXPECT_EQ(code_of([&] { anneal::refuse_what_cannot_be(population, shapes, 0, 2 * needed); }), "no error");
  EXPECT_EQ(code_of([&] { anneal::refuse_what_cannot_be(population, shapes, 0, 0); }),
            "no error");  // unknown
  EXPECT_TRUE(code_of([&] {
                anneal::refuse_what_cannot_be(population, shapes, 0, needed);
              }).starts_with("not-enough-memory"));
}

TEST(Anneal, TilesSideBySide) {
  const auto shapes = test::shapes_of({test::ellipsoid(1)});
  const auto run = pack(shapes, test::distribution(shapes, 1, 1.5, 0.45), {{"count", "40"}});
  EXPECT_EQ(overlaps(shapes, run.output<Particles>("particles"), 2), 0);
}

TEST(Anneal, BoxOfThreeEdges) {
  const auto shapes = test::shapes_of({test::cube()});
  const auto run = pack(shapes, test::distribution(shapes, 1, 1.4, 0.3), {{"size", "[4, 8, 6]"}});
  EXPECT_EQ(run.output<Particles>("particles").box, Vec3(4, 8, 6));
  expect_sound(shapes, run, 0.3);
}

TEST(Anneal, BoxOfTwoEdges) {
  const auto shapes = test::shapes_of({test::cube()});
  const auto run = pack(shapes, test::distribution(shapes, 1, 1.4, 0.3), {{"size", "[5, 7]"}});
  EXPECT_EQ(run.output<Particles>("particles").box, Vec3(5, 5, 7));
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
  EXPECT_EQ(anneal::audit(shapes, p, 0.1).worst, 0);
}

TEST(Anneal, JamNamesTheFractionReached) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto d = test::distribution(shapes, 1, 1.1, 0.75);
  const std::string what = code_of([&] { pack(shapes, d, {{"count", "100"}, {"iterations", "800"}}); });
  EXPECT_EQ(what.substr(0, 6), "jammed");
  EXPECT_NE(what.find("0.750 was requested"), std::string::npos);
  EXPECT_NE(what.find("volume fraction of 0.6"), std::string::npos) << what;
}

TEST(Anneal, ShrinkFreesAndReports) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto d = test::distribution(shapes, 1, 1.1, 0.8);
  const auto run = pack(shapes, d, {{"count", "100"}, {"on_jam", "shrink"}, {"iterations", "800"}});
  EXPECT_EQ(overlaps(shapes, run.output<Particles>("particles")), 0);
  EXPECT_LT(run.metrics.at("shrink"), 1);
  EXPECT_GT(run.metrics.at("packing_fraction"), 0.58);
  EXPECT_NEAR(run.metrics.at("packing_fraction"), 0.8 * std::pow(run.metrics.at("shrink"), 3), 0.01);
  EXPECT_EQ(run.warnings.size(), 1u);
}

TEST(Anneal, DropFreesAndReports) {
  const auto shapes = test::shapes_of({test::icosphere(3)});
  const auto d = test::distribution(shapes, 1, 1.1, 0.7);
  const auto run = pack(shapes, d, {{"count", "100"}, {"on_jam", "drop"}, {"iterations", "600"}});
  const auto& p = run.output<Particles>("particles");
  EXPECT_EQ(overlaps(shapes, p), 0);
  EXPECT_GT(run.metrics.at("dropped"), 0);
  EXPECT_EQ(run.metrics.at("shrink"), 1);
  EXPECT_GE(*std::min_element(p.size.begin(), p.size.end()), 1);
  EXPECT_GT(run.metrics.at("packing_fraction"), 0.5);
  EXPECT_EQ(run.warnings.size(), 1u);
}

TEST(Anneal, StartIsKeptAsItIs) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  const auto d = test::distribution(shapes, 1, 2, 0.4);
  const auto first = pack(shapes, d, {{"size", "9"}});
  const auto& p = first.output<Particles>("particles");
  const auto again = pack(shapes, d, {{"size", "9"}, {"seed", "5"}}, 2, &p);
  EXPECT_EQ(again.metrics.at("kept"), static_cast<double>(p.count()));
  EXPECT_EQ(bytes(p), bytes(again.output<Particles>("particles")));

  auto more = d;
  more.shapes[0].N_V[0] *= 1.5;
  more.volume_fraction = 0;
  const auto added = pack(shapes, more, {{"size", "9"}}, 2, &p);
  EXPECT_EQ(added.metrics.at("kept"), static_cast<double>(p.count()));
  EXPECT_GT(added.output<Particles>("particles").count(), p.count());
  EXPECT_EQ(overlaps(shapes, added.output<Particles>("particles")), 0);
}

// Fractions that frictionless bodies reach when poured and shaken, and loose ones do not.
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

// Small grains touch large ones in their dents and across their ridges, where a choice of surface points made
// for flat partners sees nothing.
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

// Wherever the user stops, no further report comes: one interval between checks is all the work still done.
TEST(Anneal, StopsWithinOneReport) {
  const auto shapes = test::shapes_of({test::peanut(2), test::cube()});
  const auto d = test::distribution(shapes, 1, 2, 0.5);
  anneal::PackOptions options;
  options.population.count = 200;
  const auto run = [&](int stop) {
    std::atomic<bool> cancel{false};
    int reports = 0;
    const Work::Report report = [&](double, const std::string&) {
      if (++reports == stop) cancel = true;
    };
    const auto pack_them = [&] {
      anneal::pack_particles(d, shapes, nullptr, options, Work(&cancel, &report));
    };
    if (stop > 0)
      EXPECT_THROW(pack_them(), Cancelled) << "at report " << stop;
    else
      pack_them();
    return reports;
  };
  const int all = run(0);
  ASSERT_GT(all, 4);
  for (int stop = 1; stop < all; stop += std::max(1, all / 8)) EXPECT_EQ(run(stop), stop);
}

TEST(Anneal, PolyhedraKeepTheirDistanceByTheAudit) {
  const auto shapes = test::shapes_of({test::cube(), test::peanut(2)});
  const auto run =
      pack(shapes, test::distribution(shapes, 1, 1.5, 0.3), {{"count", "120"}, {"binder_gap", "0.05"}});
  const auto& p = run.output<Particles>("particles");
  EXPECT_LE(run.metrics.at("max_penetration"), 1e-4);
  EXPECT_LE(anneal::audit(shapes, p, 0.05).worst, 1e-4);
  EXPECT_GT(anneal::audit(shapes, p, 0.5).worst, 0.01);
}

TEST(Anneal, SectionsAreAlikeAlongTheAxes) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  const auto run = pack(shapes, test::distribution(shapes, 1, 1.5, 0.4), {{"count", "300"}});
  EXPECT_GT(run.metrics.at("section_isotropy"), 0.97);
  Particles aligned = run.output<Particles>("particles");
  for (auto& q : aligned.orientation) q = Quat::Identity();
  const Vec3 cut = anneal::sections_per_area(shapes, aligned);
  EXPECT_NEAR(cut[0] / cut[2], 1.25 / 0.8, 1e-6);
}

TEST(Anneal, VolumeFractionHoldsWhereShapesDisagree) {
  const auto shapes = test::shapes_of({test::cube()});
  auto d = test::distribution(shapes, 1, 1.2, 0.3);
  d.volume_fraction = 0.4;
  const auto run = pack(shapes, d, {{"count", "200"}});
  EXPECT_NEAR(run.metrics.at("packing_fraction"), 0.4, 0.004);
  EXPECT_EQ(run.warnings.size(), 1u);
  EXPECT_NEAR(
      pack(shapes, d, {{"count", "200"}, {"conserve", "number_density"}}).metrics.at("packing_fraction"), 0.3,
      0.003);
}

TEST(Anneal, BadInput) {
  const auto shapes = test::shapes_of({test::cube()});
  auto d = test::distribution(shapes, 1, 2, 0.3);
  const auto code = [&](const std::map<std::string, std::string>& parameters) {
    const std::string what = code_of([&] { pack(shapes, d, parameters); });
    return what.substr(0, what.find(':'));
  };
  EXPECT_EQ(code({{"size", "1.5"}}), "box-too-small");
  EXPECT_EQ(code({{"size", "1000"}}), "too-many-particles");
  EXPECT_EQ(code({{"binder_gap", "2"}, {"count", "200"}}), "impossible-density");
  EXPECT_EQ(code({{"size", "[10, 1.2, 10]"}}), "box-too-small");
  auto open = shapes;
  open.shapes[0].mesh.triangles.pop_back();
  EXPECT_EQ(code_of([&] { pack(open, d, {}); }).substr(0, 9), "open-mesh");
  auto good = d;
  for (auto& n : d.shapes[0].N_V) n = 0;
  EXPECT_EQ(code({}), "no-particles");
  d.shapes[0].N_V[1] = std::nan("");
  EXPECT_EQ(code({}), "bad-distribution");
  d = good, d.shapes[0].shape = 3;
  EXPECT_EQ(code({}), "bad-distribution");
  d = good, d.shapes.clear();
  EXPECT_EQ(code({}), "no-particles");
  d = good, d.volume_fraction = 1.2;
  EXPECT_EQ(code({}), "impossible-density");
  d = good;
  for (auto& n : d.shapes[0].N_V) n *= 1e-6;
  d.volume_fraction = 0;
  EXPECT_EQ(code({{"size", "3"}}), "no-particles");
}

TEST(Anneal, AsManyAsAreAllowed) {
  const auto shapes = test::shapes_of({test::cube()});
  const auto d = test::distribution(shapes, 1, 2, 0.3);
  anneal::PopulationOptions o;
  for (std::int64_t most = 100; most < 140; ++most) {
    o.count = o.most = most;
    EXPECT_NEAR(static_cast<double>(anneal::populate(d, shapes, nullptr, o).particles.count()),
                static_cast<double>(most), 2);
    o.most = most - 1;
    EXPECT_THROW(anneal::populate(d, shapes, nullptr, o), Error);
  }
}

}  // namespace
}  // namespace terrazzo

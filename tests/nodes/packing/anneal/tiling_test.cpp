// Tests of the periodic box and its seam.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/nodes/packing/anneal/packing_support.h"

namespace terrazzo {
namespace {

using test::expect_sound;
using test::pack;
using test::brute::overlaps;

// Planes in the seam and planes midway between two seams cut equal numbers, areas and touching pairs.
TEST(Anneal, TheSeamIsAPlaneLikeAnyOther) {
  const auto shapes = test::shapes_of({test::cube()});
  constexpr int runs = 16;
  // Per axis and packing: seam minus middle, for the cut particles, their area, and pairs that touch across.
  std::vector<std::array<double, 3>> difference;
  double pairs_seen = 0;
  for (int seed = 1; seed <= runs; ++seed) {
    const auto run = pack(shapes, test::distribution(shapes, 1, 1.3, 0.5),
                          {{"count", "150"}, {"seed", std::to_string(seed)}});
    const auto& p = run.output<Particles>("particles");
    const double near = 1.3;  // centers of touching cubes of size 1 are about this far apart
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
          if (std::abs(x) < reach) {
            d[0] += sign;
            d[1] += sign * std::sqrt(1 - std::pow(x / reach, 2));
          }
          for (std::size_t j = 0; j < p.count(); ++j) {
            if (i == j) continue;
            Vec3 v = p.position[j] - p.position[i];
            for (int a = 0; a < 3; ++a) v[a] -= p.box[a] * std::round(v[a] / p.box[a]);
            if (v.norm() < near && x < 0 && x + v[axis] >= 0) {
              d[2] += sign;
              pairs_seen += 1;
            }
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

TEST(Anneal, SectionsAreAlikeAlongTheAxes) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  const auto run = pack(shapes, test::distribution(shapes, 1, 1.5, 0.4), {{"count", "300"}});
  EXPECT_GT(run.metrics.at("section_isotropy"), 0.97);
  Particles aligned = run.output<Particles>("particles");
  for (auto& q : aligned.orientation) q = Quat::Identity();
  const Vec3 cut = packing::sections_per_area(shapes, aligned);
  EXPECT_NEAR(cut[0] / cut[2], 1.25 / 0.8, 1e-6);
}

}  // namespace
}  // namespace terrazzo

// Runs of the packer: cancellation, determinism, many particles.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "nodes/packing/rigid/packing.h"
#include "nodes/packing/rigid/spatial_order.h"
#include "runtime/random.h"
#include "tests/nodes/packing/anneal/packing_support.h"

namespace terrazzo {
namespace {

using test::bytes_of;
using test::pack;

TEST(Anneal, StopsWhenCancelled) {
  const auto shapes = test::shapes_of({test::ellipsoid(2)});
  const std::atomic<bool> cancel{true};
  packing::PackOptions options;
  options.population.count = 300;
  EXPECT_THROW(packing::pack_particles(test::distribution(shapes, 1, 2, 0.5), shapes, nullptr, options,
                                       Work(&cancel, nullptr)),
               Cancelled);
}

// After a cancellation at any report, no other report follows: at most one interval between
// checks is still computed.
TEST(Anneal, StopsWithinOneReport) {
  const auto shapes = test::shapes_of({test::peanut(2), test::cube()});
  const auto d = test::distribution(shapes, 1, 2, 0.5);
  packing::PackOptions options;
  options.population.count = 200;
  const auto run = [&](int stop) {
    std::atomic<bool> cancel{false};
    int reports = 0;
    const Work::Report report = [&](double, const std::string&) {
      if (++reports == stop) cancel = true;
    };
    const auto pack_them = [&] {
      packing::pack_particles(d, shapes, nullptr, options, Work(&cancel, &report));
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

TEST(Anneal, SameBitsForAnyNumberOfThreads) {
  const auto shapes = test::shapes_of({test::peanut(2), test::cube()});
  const auto d = test::distribution(shapes, 1, 2, 0.45);
  const std::map<std::string, std::string> parameters{{"count", "120"}, {"seed", "7"}};
  const auto one = bytes_of(pack(shapes, d, parameters, 1).output<Particles>("particles"));
  EXPECT_EQ(one, bytes_of(pack(shapes, d, parameters, 2).output<Particles>("particles")));
  EXPECT_EQ(one, bytes_of(pack(shapes, d, parameters, 7).output<Particles>("particles")));
  EXPECT_NE(one,
            bytes_of(pack(shapes, d, {{"count", "120"}, {"seed", "8"}}, 1).output<Particles>("particles")));
}

TEST(Anneal, SameBitsOfDenseSpheresForAnyNumberOfThreads) {
  const auto shapes = test::shapes_of({test::icosphere(2)});
  const auto d = test::distribution(shapes, 1, 1.2, 0.58);
  const auto one = bytes_of(pack(shapes, d, {{"count", "300"}}, 1).output<Particles>("particles"));
  for (const int threads : {2, 7})
    EXPECT_EQ(one, bytes_of(pack(shapes, d, {{"count", "300"}}, threads).output<Particles>("particles")));
}

TEST(Anneal, SpatialOrderKeepsNeighborsTogether) {
  std::vector<Vec3> points;
  for (std::uint64_t i = 0; i < 4096; ++i) {
    Random r(1, 0, i);
    points.push_back(Vec3(2 * r.uniform(), 3 * r.uniform(), r.uniform()));
  }
  const auto order = packing::spatial_order(Vec3(2, 3, 1), points);
  auto sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], static_cast<std::int32_t>(i));
  auto moved = points;
  packing::reorder(moved, order);
  EXPECT_EQ(moved[7], points[static_cast<std::size_t>(order[7])]);
  double step = 0, before = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    step += (moved[i] - moved[i - 1]).cwiseQuotient(Vec3(2, 3, 1)).norm();
    before += (points[i] - points[i - 1]).cwiseQuotient(Vec3(2, 3, 1)).norm();
  }
  EXPECT_LT(step, 0.2 * before);  // the mean step between random points is 0.66
}

// Many particles are packed in spatial order, but the output has the original order, for
// any number of threads.
TEST(Anneal, ManyComeOutInTheirOrder) {
  const auto shapes = test::shapes_of({test::icosphere(2)});
  const auto d = test::distribution(shapes, 1, 2, 0.2);
  const std::map<std::string, std::string> parameters{{"count", "51000"}};
  const auto run = pack(shapes, d, parameters, 2);
  const auto& p = run.output<Particles>("particles");
  ASSERT_GT(p.count(), 50000u);
  EXPECT_EQ(run.metrics.at("max_penetration"), 0);
  for (std::size_t i = 1; i < p.count(); ++i) ASSERT_GE(p.size[i - 1], p.size[i]);
  // Uniformly distributed: no part of the box is missing.
  std::array<int, 8> octant{};
  for (const Vec3& x : p.position)
    ++octant[(x[0] * 2 > p.box[0]) + 2 * (x[1] * 2 > p.box[1]) + 4 * (x[2] * 2 > p.box[2])];
  for (const int n : octant) EXPECT_NEAR(n, p.count() / 8.0, 400);
  EXPECT_EQ(bytes_of(p), bytes_of(pack(shapes, d, parameters, 1).output<Particles>("particles")));
}

}  // namespace
}  // namespace terrazzo

// The parts of the segmentation, each checked against exact results.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "nodes/common/geometry/components.h"
#include "nodes/photograph/segment/color/clustering.h"
#include "nodes/photograph/segment/color/min_cut.h"
#include "nodes/photograph/segment/color/pieces.h"
#include "nodes/photograph/segment/color/split.h"
#include "nodes/photograph/segment/color/watershed.h"
#include "nodes/photograph/segment/measure/measure.h"
#include "nodes/photograph/segment/outline/coverage.h"
#include "nodes/photograph/segment/outline/outline.h"
#include "runtime/random.h"
#include "tests/nodes/photograph/segment/synthetic_section.h"

namespace terrazzo {
namespace {
using namespace segment;

TEST(SegmentParts, DistanceAgainstBruteForce) {
  Random random(3);
  const int w = 23, h = 17;
  for (int round = 0; round < 20; ++round) {
    std::vector<std::int32_t> r(w * h);
    for (auto& v : r) v = random.uniform() < 0.06 ? 0 : random.uniform() < 0.05 ? 2 : 1;
    const bool outside = round % 2;
    const auto d = squared_distance(r, w, h, outside, {});
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        if (r[y * w + x] == 0) continue;
        double best = 1e12;
        for (int v = -1; v <= h; ++v)
          for (int u = -1; u <= w; ++u) {
            const bool in = u >= 0 && v >= 0 && u < w && v < h;
            if (in ? r[v * w + u] == r[y * w + x] : !outside) continue;
            best = std::min(best, std::pow(u - x, 2.0) + std::pow(v - y, 2.0));
          }
        if (best >= 1e12) continue;
        EXPECT_EQ(d[y * w + x], best) << x << " " << y << " round " << round;
      }
  }
}

TEST(SegmentParts, MinimumCutAgainstAllLabellings) {
  Random random(9);
  for (int round = 0; round < 40; ++round) {
    const int n = 9;
    std::vector<double> f(n), t(n);
    for (int k = 0; k < n; ++k) {
      f[k] = random.below(64);
      t[k] = random.below(64);
    }
    std::vector<CutEdge> edges;
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < a; ++b)
        if (random.uniform() < 0.4) edges.push_back({a, b, static_cast<double>(random.below(32))});
    const auto cost = [&](auto label) {
      double c = 0;
      for (int k = 0; k < n; ++k) c += label(k) ? t[k] : f[k];
      for (const auto& e : edges) c += label(e.a) != label(e.b) ? e.weight : 0;
      return c;
    };
    double best = 1e9;
    for (int m = 0; m < 1 << n; ++m) best = std::min(best, cost([&](int k) { return (m >> k & 1) != 0; }));
    const auto cut = min_cut(f, t, edges, {});
    EXPECT_EQ(cost([&](int k) { return static_cast<bool>(cut[k]); }), best);
  }
}

TEST(SegmentParts, WatershedCoversAllAndParts) {
  const int w = 40, h = 20;
  std::vector<float> relief(w * h);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      relief[y * w + x] =
          static_cast<float>(std::min(std::hypot(x - 9.0, y - 10.0), std::hypot(x - 30.0, y - 9.0)));
  const auto basins = watershed(relief, w, h, {});
  EXPECT_EQ(std::set<std::int32_t>(basins.begin(), basins.end()), (std::set<std::int32_t>{1, 2}));
  EXPECT_NE(basins[10 * w + 9], basins[9 * w + 30]);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const double a = std::hypot(x - 9.0, y - 10.0), b = std::hypot(x - 30.0, y - 9.0);
      if (std::abs(a - b) <= 1.5) continue;
      EXPECT_EQ(basins[y * w + x], basins[a < b ? 10 * w + 9 : 9 * w + 30]);
    }
}

TEST(SegmentParts, SplitStrengthMovesTheNeck) {
  const int w = 120, h = 60;
  std::vector<std::int32_t> r(w * h, 0);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)  // two disks of radius 20, joined by a bar 60 % as wide
      r[y * w + x] = std::hypot(x - 30, y - 30) < 20 || std::hypot(x - 88, y - 30) < 20 ||
                     (x > 30 && x < 88 && std::abs(y - 30) < 12);
  const auto count = [&](double strength) {
    const auto s = split_at_necks(r, w, h, strength, {});
    return *std::max_element(s.begin(), s.end());
  };
  EXPECT_EQ(count(0), 1);
  EXPECT_EQ(count(0.2), 1);
  EXPECT_GE(count(0.6), 2);
}

TEST(SegmentParts, PiecesOfARectangle) {
  std::vector<std::int32_t> r(12 * 8, 0);
  for (int y = 2; y < 6; ++y)
    for (int x = 0; x < 5; ++x) r[y * 12 + x] = x < 3 ? 1 : 2;
  const auto p = measure_pieces(r, 12, 8);
  ASSERT_EQ(p.size(), 2u);
  EXPECT_EQ(p[0].area, 12);
  EXPECT_EQ(p[0].hull_area, 12);
  EXPECT_EQ(p[0].outline, 6);
  EXPECT_EQ(p[0].contact, 4);
  EXPECT_EQ(p[0].at_border, 4);
  EXPECT_EQ(p[1].left, 3);
}

TEST(SegmentParts, ComponentsByCornersOrEdges) {
  const std::vector<std::int32_t> r = {1, 0, 2, 0, 1, 0, 1, 0, 1};
  EXPECT_EQ(connected_components(r, 3, 3, false).count(), 5);
  const auto joined = connected_components(r, 3, 3, true);
  EXPECT_EQ(joined.count(), 2);
  EXPECT_EQ(joined.sizes[0], 4);
  EXPECT_EQ(joined.values[1], 2);
}

TEST(SegmentParts, KMeansFindsSeparateClusters) {
  Random random(4);
  std::vector<Vec3f> points;
  const Vec3f truth[3] = {{0.1f, 0, 0}, {0.5f, 0.1f, 0}, {0.9f, 0, 0.1f}};
  for (int i = 0; i < 600; ++i)
    points.push_back(truth[i % 3] + 0.02f * Vec3f(random.normal(), random.normal(), random.normal()));
  const Clusters c = k_means(points, 3, 1, {});
  ASSERT_EQ(c.centers.size(), 3u);
  for (int k = 0; k < 3; ++k) EXPECT_LT((c.centers[k] - truth[k]).norm(), 0.01);
  EXPECT_GT(c.silhouette, k_means(points, 2, 1, {}).silhouette);
  EXPECT_GT(c.silhouette, k_means(points, 5, 1, {}).silhouette);
  EXPECT_EQ(k_means({Vec3f::Ones(), Vec3f::Ones()}, 3, 1, {}).centers.size(), 1u);
}

TEST(SegmentParts, OutlineOfExactCoverage) {
  // With exact coverage, the outline of a disk is accurate to a hundredth of its area and counterclockwise.
  for (const double radius : {5.3, 8.0, 15.7}) {
    Image image(48, 48, 1, 1, Vec3f::Zero());
    test::draw(image, {23.4, 24.7, radius}, Vec3f::Ones());
    std::vector<std::int32_t> labels(48 * 48);
    std::vector<float> share(48 * 48);
    for (std::size_t i = 0; i < labels.size(); ++i)
      share[i] = image.pixels[i][0], labels[i] = share[i] >= 0.5f;
    const auto o = outlines(labels, share, 48, 48, 1, {});
    const double truth = std::numbers::pi * radius * radius;
    EXPECT_NEAR(o[0].area, truth, 0.01 * truth) << radius;
    EXPECT_LT((o[0].centroid - Vec2(23.4, 48 - 24.7)).norm(), 0.03);
    double twice = 0;
    for (std::size_t k = 0; k < o[0].points.size(); ++k) {
      const Vec2 &p = o[0].points[k], &q = o[0].points[(k + 1) % o[0].points.size()];
      twice += p.x() * q.y() - p.y() * q.x();
    }
    EXPECT_NEAR(twice / 2, o[0].area, 1e-9);
  }
}

TEST(SegmentParts, OutlineOfAPolygonAndAtTheBorder) {
  // A rectangle from the image's lower left corner to half a pixel beyond a pixel's edge.
  const int w = 20, h = 12;
  std::vector<std::int32_t> labels(w * h, 0);
  std::vector<float> share(w * h, 0);
  for (int y = 4; y < h; ++y)
    for (int x = 0; x < 8; ++x) labels[y * w + x] = 1, share[y * w + x] = 1;
  const auto o = outlines(labels, share, w, h, 1, {});
  double left = 1e9, low = 1e9, right = 0, top = 0;
  for (const auto& p : o[0].points)
    left = std::min(left, p.x()), right = std::max(right, p.x()), low = std::min(low, p.y()),
    top = std::max(top, p.y());
  EXPECT_DOUBLE_EQ(left, 0);
  EXPECT_DOUBLE_EQ(low, 0);
  EXPECT_DOUBLE_EQ(right, 8);
  EXPECT_DOUBLE_EQ(top, 8);
  EXPECT_NEAR(o[0].area, 64, 0.51);  // each corner loses an eighth of a pixel
}

TEST(SegmentParts, BorderWeightsGiveAnUnbiasedDensity) {
  // Random windows of a large periodic field of disks of two sizes: Σ weight / window estimates N_A.
  const int field = 600, window = 90;
  const auto discs = test::scatter(field, field, 120, 4, 22, 21, 2);
  std::vector<std::int32_t> ids(static_cast<std::size_t>(field) * field, 0);
  for (std::size_t k = 0; k < discs.size(); ++k)
    for (int y = 0; y < field; ++y)
      for (int x = std::max(0, static_cast<int>(discs[k].x - 24)); x < std::min<int>(field, discs[k].x + 25);
           ++x)
        if (std::hypot(x + 0.5 - discs[k].x, y + 0.5 - discs[k].y) < discs[k].radius)
          ids[static_cast<std::size_t>(y) * field + x] = static_cast<std::int32_t>(k + 1);
  Random random(8);
  double density = 0, naive = 0;
  const int rounds = 400;
  const Image image(window, window, 1, 1);
  for (int round = 0; round < rounds; ++round) {
    const int ox = static_cast<int>(random.below(field)), oy = static_cast<int>(random.below(field));
    Labels labels;
    labels.width = labels.height = window;
    std::vector<std::int32_t> number(discs.size() + 1, 0);
    for (int y = 0; y < window; ++y)
      for (int x = 0; x < window; ++x) {
        const std::int32_t id = ids[static_cast<std::size_t>((y + oy) % field) * field + (x + ox) % field];
        if (id != 0 && number[id] == 0) {
          labels.classes.push_back(0);
          number[id] = labels.count();
        }
        labels.ids.push_back(id == 0 ? 0 : number[id]);
      }
    const Profiles p = measure_profiles(image, labels, std::vector<float>(labels.ids.size(), 1), {}, {}, {});
    for (const auto& q : p.profiles) {
      EXPECT_EQ(q.weight == 0, q.touches_border);
      density += q.weight;
      naive += 1;
    }
  }
  const double truth = static_cast<double>(discs.size()) / (static_cast<double>(field) * field);
  density /= static_cast<double>(rounds) * window * window;
  naive /= static_cast<double>(rounds) * window * window;
  EXPECT_NEAR(density, truth, 0.05 * truth);
  EXPECT_GT(naive, 1.2 * truth);  // the result of counting all profiles
}

}  // namespace
}  // namespace terrazzo

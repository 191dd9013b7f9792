#include "nodes/photograph/synthetic_photo/joined_grains.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "nodes/common/geometry/components.h"

namespace terrazzo {
namespace {
using namespace synthetic_photo;

Canvas grown(std::uint64_t seed, double fill) {
  Canvas c(384, 320);
  Random r(seed, 1, 2);
  grow_together(c, fill, r, {});
  return c;
}

// Area of each grain relative to its convex hull's, of those that the border does not cut.
std::vector<double> solidities(const Canvas& c) {
  std::vector<double> out;
  for (int id = 1; id <= c.particles; ++id) {
    std::vector<cv::Point> corners;
    double area = 0;
    bool cut = false;
    for (int y = 0; y < c.height; ++y)
      for (int x = 0; x < c.width; ++x) {
        if (c.id[c.at(x, y)] != id) continue;
        ++area;
        cut = cut || x == 0 || y == 0 || x == c.width - 1 || y == c.height - 1;
        for (const cv::Point corner : {cv::Point(0, 0), cv::Point(1, 0), cv::Point(0, 1), cv::Point(1, 1)})
          corners.push_back(cv::Point(x, y) + corner);
      }
    if (cut) continue;
    std::vector<cv::Point> hull;
    cv::convexHull(corners, hull);
    out.push_back(area / cv::contourArea(hull));
  }
  return out;
}

// The truth that lobed grains need: an outline with necks is one particle, and a channel separates two.
TEST(JoinedGrains, WhatIsConnectedIsOneParticle) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Canvas c = grown(seed, 0.5);
    std::vector<std::int32_t> grains(c.id.size());
    for (std::size_t i = 0; i < grains.size(); ++i) grains[i] = c.id[i] > 0;
    const Components parts = connected_components(grains, c.width, c.height, false);
    EXPECT_EQ(parts.count(), c.particles) << seed;
    EXPECT_EQ(parts.ids, c.id) << seed;
  }
}

TEST(JoinedGrains, ManyAreLobedAndManyAreNot) {
  std::vector<double> all;
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
    for (const double s : solidities(grown(seed, 0.5))) all.push_back(s);
  ASSERT_GT(all.size(), 50u);
  const auto below = [&](double limit) {
    return static_cast<double>(std::count_if(all.begin(), all.end(), [&](double s) { return s < limit; })) /
           static_cast<double>(all.size());
  };
  EXPECT_GT(below(0.8), 0.1);
  EXPECT_LT(below(0.9), 0.7);
}

TEST(JoinedGrains, FillSetsTheAreaFraction) {
  for (const double fill : {0.3, 0.5, 0.65}) {
    double sum = 0;
    const int canvases = 12;
    for (int seed = 1; seed <= canvases; ++seed) {
      const Canvas c = grown(static_cast<std::uint64_t>(seed), fill);
      sum +=
          1 - static_cast<double>(std::count(c.id.begin(), c.id.end(), 0)) / static_cast<double>(c.id.size());
    }
    EXPECT_NEAR(sum / canvases, fill, 0.08) << fill;
  }
}

}  // namespace
}  // namespace terrazzo

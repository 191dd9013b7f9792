// Materials without a binder.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "nodes/data/labels.h"
#include "nodes/data/profiles.h"
#include "nodes/photograph/segment/outline/fill_gaps.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using segment::fill_gaps;

// Squares of 20 pixels, in four shades so that neighbors differ.
Image chessboard(int cells) {
  Image image;
  image.width = image.height = 20 * cells;
  image.pixels.resize(static_cast<std::size_t>(image.width) * image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const int i = x / 20, j = y / 20;
      image.pixels[image.index(x, y, 0)] = Vec3f(i % 2 ? 0.8f : 0.2f, j % 2 ? 0.7f : 0.1f, 0.3f);
    }
  return image;
}

// The middle of each square is a particle, except where `without` says so.
std::vector<std::int32_t> middles(const Image& image, int without = -1) {
  std::vector<std::int32_t> labels(image.pixels.size(), 0);
  const int cells = image.width / 20;
  std::int32_t next = 0;
  for (int k = 0; k < cells * cells; ++k) {
    if (k == without) continue;
    ++next;
    for (int y = 3; y < 17; ++y)
      for (int x = 3; x < 17; ++x) labels[image.index(20 * (k % cells) + x, 20 * (k / cells) + y, 0)] = next;
  }
  return labels;
}

TEST(FillGaps, ParticlesGrowToTheEdgesOfColor) {
  const Image image = chessboard(5);
  auto labels = middles(image);
  const auto before = labels;
  EXPECT_EQ(fill_gaps(labels, image, 0), 25);
  std::map<std::int32_t, int> pixels;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    ASSERT_GT(labels[i], 0);
    if (before[i] > 0) {
      EXPECT_EQ(labels[i], before[i]);
    }
    ++pixels[labels[i]];
  }
  for (const auto& [label, n] : pixels) EXPECT_NEAR(n, 400, 60) << label;
}

TEST(FillGaps, WhatIsFarFromAllBecomesAParticle) {
  const Image image = chessboard(5);
  auto labels = middles(image, 12);
  EXPECT_EQ(fill_gaps(labels, image, 0), 25);
  const std::int32_t added = labels[image.index(50, 50, 0)];
  EXPECT_EQ(added, 25);
  EXPECT_NEAR(static_cast<double>(std::count(labels.begin(), labels.end(), added)), 400, 60);
}

TEST(FillGaps, NothingFound) {
  const Image image = chessboard(2);
  std::vector<std::int32_t> labels(image.pixels.size(), 0);
  EXPECT_EQ(fill_gaps(labels, image, 0), 1);
  EXPECT_EQ(std::count(labels.begin(), labels.end(), 1), static_cast<std::ptrdiff_t>(labels.size()));
}

// Voronoi cells of random seeds in random colors, with noise.
TEST(FillGaps, SegmentWithoutBinder) {
  constexpr int kCells = 60;
  Random r(4);
  Image image;
  image.width = image.height = 256;
  image.pixel_size = 0.1;
  std::vector<Vec2> seeds;
  std::vector<Vec3f> colors;
  for (int k = 0; k < kCells; ++k) {
    seeds.push_back(256 * Vec2(r.uniform(), r.uniform()));
    colors.push_back(Vec3(r.uniform(), r.uniform(), r.uniform()).cast<float>());
  }
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      const auto nearest = std::min_element(seeds.begin(), seeds.end(), [&](const Vec2& a, const Vec2& b) {
        return (a - Vec2(x, y)).norm() < (b - Vec2(x, y)).norm();
      });
      const double noise = 1 + 0.05 * r.normal();
      image.pixels.push_back(static_cast<float>(noise) *
                             colors[static_cast<std::size_t>(nearest - seeds.begin())]);
    }
  const auto run = test::run_node("Segment", {{"image", Value::of<Image>(image)}}, {{"binder", "none"}});
  const auto& labels = run.output<Labels>("labels");
  EXPECT_EQ(std::count(labels.ids.begin(), labels.ids.end(), 0), 0);
  EXPECT_EQ(run.output<Profiles>("profiles").area_fraction, 1);
  EXPECT_EQ(labels.classes.size(), run.output<Profiles>("profiles").profiles.size());
  EXPECT_GT(labels.classes.size(), kCells / 2u);
  EXPECT_LT(labels.classes.size(), 2u * kCells);
}

TEST(FillGaps, ClustersNeedABinder) {
  EXPECT_EQ(test::code_of([] {
              test::run_node("Segment", {{"image", Value::of<Image>(chessboard(3))}},
                             {{"binder", "none"}, {"method", "clusters"}});
            }),
            "needs-binder");
}

}  // namespace
}  // namespace terrazzo

// Segmentation in tiles, compared with the whole picture at once.
#include "nodes/photograph/segment/tiles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/photograph/instance_score/instance_score.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace segment;

// White discs and one long bar across the border of the first two tiles, on gray; their labels.
Image white_discs(int width, int height, Labels& labels) {
  Image image(width, height, 1, 1, Vec3f::Constant(0.2f));
  labels.width = width;
  labels.height = height;
  labels.sections = 1;
  labels.ids.assign(image.pixels.size(), 0);
  Random random(7);
  const auto draw = [&](const auto& inside, int left, int top, int right, int bottom) {
    const auto free = [&] {
      for (int y = top - 4; y < bottom + 4; ++y)
        for (int x = left - 4; x < right + 4; ++x)
          if (x >= 0 && y >= 0 && x < width && y < height && labels.ids[image.index(x, y, 0)] != 0)
            return false;
      return true;
    };
    if (!free()) return;
    labels.classes.push_back(0);
    for (int y = std::max(0, top); y < std::min(height, bottom); ++y)
      for (int x = std::max(0, left); x < std::min(width, right); ++x)
        if (inside(x, y)) {
          image.at(x, y) = Vec3f::Constant(0.8f);
          labels.ids[image.index(x, y, 0)] = labels.count();
        }
  };
  draw([](int, int) { return true; }, 1500, 40, 2700, 80);
  // Around and across the border of the tiles, where something could go wrong, and some elsewhere.
  for (int k = 0; k < 400; ++k) {
    const double x = k < 150 ? 2048 + 300 * random.normal() : random.uniform(0, width),
                 y = random.uniform(0, height), r = random.uniform(5, 30);
    draw([&](int u, int v) { return std::hypot(u - x, v - y) < r; }, static_cast<int>(x - r),
         static_cast<int>(y - r), static_cast<int>(x + r) + 1, static_cast<int>(y + r) + 1);
  }
  return image;
}

TEST(SegmentTiles, GiveTheParticlesOfTheWholePicture) {
  Labels truth;
  const Image image = white_discs(2700, 500, truth);
  SegmentOptions options;
  options.method = Method::Clusters;
  const Finding found = find_in_tiles(image, options, {});
  EXPECT_EQ(found.result.method, Method::Clusters);
  EXPECT_EQ(found.confidence.size(), found.result.labels.classes.size());
  const auto score = instance_score::compare_instances(found.result.labels, truth);
  EXPECT_EQ(score.average_precision(0.8), 1) << found.result.labels.count() << " of " << truth.count();
  for (std::size_t i = 0; i < found.coverage.size(); ++i)
    ASSERT_EQ(found.coverage[i] >= 0.5f, found.result.labels.ids[i] > 0) << i;
}

TEST(SegmentTiles, CoverEveryPixelOnce) {
  for (const auto& [w, h] : {std::pair{5000, 4100}, {2048, 9000}, {2049, 2047}}) {
    std::int64_t cores = 0;
    for (const Tile& t : tiles_of(w, h, 2)) {
      cores += static_cast<std::int64_t>(t.right - t.left) * (t.bottom - t.top);
      EXPECT_TRUE(t.seen_left <= t.left && t.seen_top <= t.top);
      EXPECT_TRUE(t.seen_right >= t.right && t.seen_bottom >= t.bottom);
      EXPECT_TRUE(t.seen_left >= 0 && t.seen_top >= 0 && t.seen_right <= w && t.seen_bottom <= h);
    }
    EXPECT_EQ(cores, 2 * static_cast<std::int64_t>(w) * h);
  }
}

TEST(SegmentTiles, TellWhatTheyCannotDo) {
  SegmentOptions options;
  options.method = Method::Scribbles;
  EXPECT_EQ(test::code_of([&] { find_in_tiles(Image(64, 64, 1, 1), options, {}); }), "too-large");
  options = {};
  options.memory = 1000;
  EXPECT_EQ(test::code_of([&] { segment::segment(Image(64, 64, 1, 1), options, {}); }), "too-large");
}

}  // namespace
}  // namespace terrazzo

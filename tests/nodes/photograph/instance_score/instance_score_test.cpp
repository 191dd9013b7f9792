#include <gtest/gtest.h>

#include "nodes/photograph/instance_score/instance_score.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using namespace instance_score;

Labels raster(int width, int height, int count) {
  Labels l;
  l.width = width;
  l.height = height;
  l.ids.assign(static_cast<std::size_t>(width) * height, 0);
  l.classes.assign(static_cast<std::size_t>(count), 0);
  return l;
}
void fill(Labels& l, int id, int x0, int y0, int x1, int y1) {
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) l.ids[l.index(x, y)] = id;
}

TEST(InstanceScore, EqualLabelsScoreOneWhateverTheirNumbers) {
  Random random(3);
  Labels a = raster(40, 30, 12), b = a;
  for (int k = 0; k < 12; ++k) {
    const int x = 10 * (k % 4), y = 10 * (k / 4);
    const int w = 2 + static_cast<int>(random.below(7)), h = 2 + static_cast<int>(random.below(7));
    fill(a, k + 1, x, y, x + w, y + h);
    fill(b, 12 - k, x, y, x + w, y + h);
  }
  const Score s = compare_instances(a, b);
  EXPECT_EQ(s.found, 12);
  EXPECT_EQ(s.masks, 12);
  EXPECT_EQ(s.average_precision(0.5), 1);
  EXPECT_EQ(s.average_precision(0.75), 1);
  EXPECT_EQ(s.recall(0.5), 1);
  EXPECT_EQ(s.found_area, s.mask_area);
}

// A 10 × 10 square moved by d columns overlaps its place by (10 − d) / (10 + d).
TEST(InstanceScore, OverlapOfAMovedSquare) {
  for (int d = 0; d <= 5; ++d) {
    Labels mask = raster(30, 10, 1), found = mask;
    fill(mask, 1, 5, 0, 15, 10);
    fill(found, 1, 5 + d, 0, 15 + d, 10);
    const Score s = compare_instances(found, mask);
    const double overlap = (10.0 - d) / (10 + d);
    EXPECT_EQ(s.matched(0.5), overlap >= 0.5) << d;
    EXPECT_EQ(s.matched(0.75), overlap >= 0.75) << d;
    if (overlap >= 0.5) EXPECT_DOUBLE_EQ(s.matches.at(0).overlap, overlap);
  }
}

// Two of three masks found, one particle invented: 2 / (2 + 1 + 1). One mask split in two halves matches
// once.
TEST(InstanceScore, CountsMissedAndInvented) {
  Labels mask = raster(60, 20, 3), found = raster(60, 20, 4);
  fill(mask, 1, 0, 0, 10, 10);
  fill(mask, 2, 20, 0, 30, 10);
  fill(mask, 3, 40, 0, 50, 10);
  fill(found, 1, 0, 0, 10, 10);
  fill(found, 2, 20, 0, 30, 9);
  fill(found, 4, 50, 12, 56, 18);
  Score s = compare_instances(found, mask);
  EXPECT_EQ(s.found, 3);  // number 3 has no pixels
  EXPECT_DOUBLE_EQ(s.average_precision(0.5), 0.5);
  EXPECT_DOUBLE_EQ(s.recall(0.5), 2.0 / 3);
  Labels whole = raster(10, 10, 1), halves = raster(10, 10, 2);
  fill(whole, 1, 0, 0, 10, 10);
  fill(halves, 1, 0, 0, 5, 10);
  fill(halves, 2, 5, 0, 10, 10);
  s = compare_instances(halves, whole);
  EXPECT_EQ(s.matched(0.5), 1);
  EXPECT_DOUBLE_EQ(s.average_precision(0.5), 0.5);
}

TEST(InstanceScore, EmptyAndOtherSizes) {
  const Labels none = raster(8, 8, 0);
  EXPECT_EQ(compare_instances(none, none).average_precision(0.5), 1);
  Labels one = raster(8, 8, 1);
  fill(one, 1, 1, 1, 4, 4);
  EXPECT_EQ(compare_instances(none, one).average_precision(0.5), 0);
  EXPECT_EQ(compare_instances(one, none).recall(0.5), 1);
  EXPECT_EQ(test::code_of([&] { compare_instances(raster(8, 9, 0), none); }), "size-mismatch");
}

}  // namespace
}  // namespace terrazzo

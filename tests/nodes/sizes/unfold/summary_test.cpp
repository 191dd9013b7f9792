// Means and quantiles of a size distribution.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/sizes/unfold/summary.h"

namespace terrazzo {
namespace {
using namespace unfold;

TEST(UnfoldSummary, MeansAndQuantilesOfKnownSizes) {
  SizeDistribution d;
  d.class_edges = {1, 2, 4};
  d.shapes.resize(2);
  d.shapes[0].N_V = {2, 0};
  d.shapes[1].N_V = {1, 1};
  const SizeSummary s = summarize(d);
  EXPECT_NEAR(s.N_V, 4, 1e-12);
  EXPECT_NEAR(s.mean, (3 * 1.5 + 3) / 4, 1e-12);
  EXPECT_NEAR(s.median, 1 + 2.0 / 3, 1e-12);
  // Volumes: 3 · (2⁴ − 1)/4 and 1 · (4⁴ − 2⁴)/8.
  EXPECT_NEAR(s.volume_share[0], 11.25 / (11.25 + 30), 1e-12);
  EXPECT_EQ(s.volume_passing[1], 1);
  EXPECT_NEAR(std::pow(s.d50, 4), 16 + 240 * (0.5 * 41.25 - 11.25) / 30, 1e-9);
  EXPECT_LT(s.d10, s.d50);
  EXPECT_LT(s.d50, s.d90);
  // A fine histogram of a lognormal reproduces its parameters.
  d.class_edges.clear();
  d.shapes.resize(1);
  d.shapes[0].N_V.clear();
  for (int i = 0; i <= 2000; ++i) d.class_edges.push_back(i * 0.01);
  for (int i = 0; i < 2000; ++i) {
    const double x = (i + 0.5) * 0.01;
    d.shapes[0].N_V.push_back(std::exp(-0.5 * std::pow(std::log(x / 3) / 0.4, 2)) / x);
  }
  const SizeSummary l = summarize(d);
  EXPECT_NEAR(l.geometric_mean, 3, 0.005);
  EXPECT_NEAR(std::log(l.geometric_sd), 0.4, 0.002);
  EXPECT_NEAR(l.d50, 3 * std::exp(3 * 0.16), 0.03);  // Hatch and Choate 1929
  EXPECT_EQ(summarize({}).N_V, 0);
}

TEST(UnfoldSummary, EquivalentDiameters) {
  KMatrix k;
  k.shapes.resize(1);
  k.shapes[0].max_section_area = 9 * std::numbers::pi / 4;  // of size 3
  k.shapes[0].volume = 27 * std::numbers::pi / 6;
  EXPECT_NEAR(equivalent_diameter(k), 1, 1e-12);
  k.shapes[0].volume /= 8;
  EXPECT_NEAR(equivalent_diameter(k), 0.5, 1e-12);
}

}  // namespace
}  // namespace terrazzo

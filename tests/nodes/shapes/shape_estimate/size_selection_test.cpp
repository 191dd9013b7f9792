#include "nodes/shapes/shape_estimate/size_selection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "nodes/shapes/shape/solids.h"
#include "runtime/random.h"

namespace terrazzo::shape_estimate {
namespace {

// Root areas above `limit` of sections through balls, whose radii are `radius` of a uniform number.
template <class Radius>
std::vector<double> ball_profiles(Radius&& radius, double limit, std::size_t count, std::uint64_t seed,
                                  std::vector<double>* relative = nullptr) {
  Random r(seed, 3);
  std::vector<double> out;
  while (out.size() < count) {
    const double size = radius(r.uniform());
    if (r.uniform() > size / 20) continue;  // planes meet particles in proportion to their size
    const double z = r.uniform(), root = std::sqrt(M_PI * (1 - z * z));
    if (root * size < limit) continue;
    out.push_back(root * size);
    if (relative) relative->push_back(root);
  }
  return out;
}

std::vector<CutProfile> unit_ball() { return cut_sections(shape::ellipsoid_mesh({2, 2, 2}, 3), 2000); }

double mean(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

double weighted_mean(const std::vector<CutProfile>& s) {
  double sum = 0, total = 0;
  for (const auto& p : s) {
    sum += p.weight * p.root_area;
    total += p.weight;
  }
  return sum / total;
}

// Exponentially distributed radii: sections far from the center are rarer above the limit.
TEST(SizeSelection, WeighsSectionsAsParticlesOfManySizesShowThem) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::vector<double> relative;
    const auto profiles = ball_profiles([](double u) { return std::min(20.0, -2 * std::log(1 - u)); }, 4,
                                        1500, seed, &relative);
    auto sections = unit_ball();
    const double all = weighted_mean(sections);
    SizeSelection(profiles, {sections}).apply(sections);
    EXPECT_NEAR(weighted_mean(sections) / mean(relative), 1, 0.02) << seed;
    EXPECT_GT(mean(relative), 1.05 * all) << seed;
  }
}

// The scales reproduce the profiles above the limit.
TEST(SizeSelection, ShowsSectionsAtTheScalesOfTheParticles) {
  const auto profiles =
      ball_profiles([](double u) { return std::min(20.0, -2 * std::log(1 - u)); }, 4, 1500, 4);
  auto sections = unit_ball();
  SizeSelection(profiles, {sections}).apply(sections);
  double sum = 0, total = 0;
  for (const auto& s : sections) {
    ASSERT_GT(s.scale * s.root_area, 4 * std::exp(-0.081));  // classes are e^0.08 wide
    sum += s.weight * std::log(s.scale * s.root_area);
    total += s.weight;
  }
  double seen = 0;
  for (const double v : profiles) seen += std::log(v) / static_cast<double>(profiles.size());
  EXPECT_NEAR(sum / total, seen, 0.04);
}

// With balls of one size, sections are seen or not: those above the limit have equal weight.
TEST(SizeSelection, FindsThatAllParticlesHaveOneSize) {
  const auto profiles = ball_profiles([](double) { return 5.0; }, 4, 1000, 5);
  auto sections = unit_ball();
  const std::size_t all = sections.size();
  SizeSelection(profiles, {sections}).apply(sections);
  double weight = 0, most = 0;
  for (const auto& s : sections) {
    weight += s.weight;
    most = std::max(most, s.weight);
  }
  // √A of at least 4 of 5√π: a depth of up to √(1 − 0.64/π) of the radius.
  EXPECT_NEAR(weight / most / static_cast<double>(all), std::sqrt(1 - 0.64 / M_PI), 0.04);
}

TEST(SizeSelection, OneSizeDropsSmallSectionsAndKeepsTheMean) {
  auto sections = unit_ball();
  const std::size_t all = sections.size();
  SizeSelection(0.5, 30).apply(sections);
  EXPECT_LT(sections.size(), all);
  EXPECT_NEAR(weighted_mean(sections) * sections[0].scale, 30, 1e-9);
}

TEST(SizeSelection, NothingStaysNothing) {
  std::vector<CutProfile> none;
  SizeSelection(std::vector<double>{1, 2, 3}, {unit_ball()}).apply(none);
  EXPECT_TRUE(none.empty());
  SizeSelection(0.5, 1).apply(none);
  EXPECT_TRUE(none.empty());
}

// A blur in mm rounds small profiles more than large ones.
TEST(SizeSelection, BlursSectionsByTheirScale) {
  auto sections = cut_sections(shape::box_mesh({1, 1, 1}), 50);
  const auto sharp = measured(sections, {});
  for (auto& s : sections) s.scale = 10;
  const auto large = measured(sections, {.blur = 0.3});
  for (auto& s : sections) s.scale = 4;
  const auto small = measured(sections, {.blur = 0.3});
  ASSERT_EQ(small.features.size(), sharp.features.size());
  std::size_t rounder = 0;  // the smallest sections are blurred as far as they can be
  for (std::size_t i = 0; i < small.features.size(); ++i) {
    const auto corner = [&](const FeatureSample& s) { return s.features[i][OutlineFeature::Corner]; };
    EXPECT_GT(corner(sharp), corner(large));
    EXPECT_GE(corner(large), corner(small));
    rounder += corner(large) > corner(small);
  }
  EXPECT_GT(10 * rounder, 9 * small.features.size());
}

}  // namespace
}  // namespace terrazzo::shape_estimate

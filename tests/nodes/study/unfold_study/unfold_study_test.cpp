#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/common/stereology/size_kernel.h"
#include "nodes/data/table.h"
#include "nodes/sizes/kmatrix/make_kmatrix.h"
#include "nodes/study/unfold_study/sample_profiles.h"
#include "nodes/study/unfold_study/study.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace kmatrix;
using namespace unfold_study;

const KMatrix& spheres() {
  static const KMatrix k = [] {
    const auto ball = test::run_node("Shape", {}, {{"kind", "sphere"}, {"size", "1"}}).outputs.at("shapes");
    return make_kmatrix(ball.as<Shapes>(), {.method = kmatrix::Method::Analytic, .classes = 10});
  }();
  return k;
}

SizeDistribution uniform(double lo, double hi, double total) {
  SizeDistribution d;
  d.class_edges = {lo, hi};
  d.d_max = hi;
  d.shapes.push_back({-1, 0, {total}, {total}, {total}});
  return d;
}

TEST(ProfileSampler, ShowsWhatClosedFormsSay) {
  // Spheres uniform in [4, 10], 0.002 per mm³: N_A = mean·N_V; E[area] = V̄·N_V/N_A.
  const TrueSizes truth(uniform(4, 10, 0.002));
  const ProfileSampler sampler(truth, spheres());
  const Profiles p = sampler.sample(200000, 4, 3, 0, {});
  const double n_a = static_cast<double>(p.profiles.size()) / p.observed_area;
  EXPECT_NEAR(n_a / (7 * 0.002), 1, 0.01);
  const double volume = std::numbers::pi / 6 * mean_cube(4, 10);
  double area = 0, largest = 0;
  for (const auto& q : p.profiles) {
    area += q.area;
    largest = std::max(largest, q.area);
  }
  EXPECT_NEAR(area / p.observed_area / (volume * 0.002), 1, 0.01);
  EXPECT_NEAR(p.area_fraction, area / p.observed_area, 1e-12);
  EXPECT_LE(largest, std::numbers::pi / 4 * 100);
  EXPECT_EQ(p.sections, 4);
  EXPECT_EQ(p.profiles.back().section, static_cast<int>((p.profiles.size() - 1) % 4));
}

TEST(TrueSizes, SumsWithinEdges) {
  const TrueSizes t(uniform(4, 10, 0.6));
  EXPECT_DOUBLE_EQ(t.total(), 0.6);
  EXPECT_DOUBLE_EQ(t.between(5, 7), 0.2);
  EXPECT_DOUBLE_EQ(t.between(0, 4), 0);
  EXPECT_DOUBLE_EQ(t.between(9, 20), 0.1);
  EXPECT_THROW(TrueSizes(uniform(1, 2, 0)), Error);
}

// Planes meet particles in proportion to their size: of sizes 0 to 4, a quarter of the particles is between 2
// and 3, but (9 − 4)/16 of the profiles.
TEST(TrueSizes, ProfilesAreWeightedBySize) {
  SizeDistribution d;
  d.class_edges = {0, 4};
  d.shapes.resize(1);
  d.shapes[0].N_V = {1};
  const TrueSizes t(d);
  EXPECT_NEAR(t.profiles_between(2, 3), 5.0 / 16, 1e-12);
  EXPECT_NEAR(t.profiles_between(-1, 9), 1, 1e-12);
  EXPECT_EQ(t.profiles_between(4, 9), 0);
}

TEST(UnfoldStudy, ErrorsFallWithMoreProfilesAndEquation4KeepsItsBias) {
  StudyOptions o;
  o.methods = {"em", "nnls", "inverse", "equation 4"};
  o.repetitions = 4;
  o.largest = unfold_study::LargestSize::Known;
  o.profiles = 1000;
  const auto few = study(uniform(0, 10, 0.0005), spheres(), o, {});
  o.profiles = 100000;
  const auto many = study(uniform(0, 10, 0.0005), spheres(), o, {});
  for (std::size_t m = 0; m < 4; ++m) {
    EXPECT_LT(many[m].error, few[m].error) << few[m].method;
    EXPECT_EQ(many[m].refused, 0);
    EXPECT_EQ(many[m].N_V.size(), 10u);
    EXPECT_TRUE(std::isnan(many[m].coverage));
    EXPECT_NEAR(many[m].total, 1, 0.1);
  }
  EXPECT_LT(many[0].error, 0.03);
  EXPECT_GT(many[3].error, 0.05);  // the bias of eq. 3: all sizes of a class at its upper edge
  EXPECT_GT(many[3].error, 2 * many[0].error);
}

// Sizes from 0 to 10 mm whose largest are rare: the largest profile is almost always smaller.
TEST(UnfoldStudy, Equation7EndsTheClassesTooEarly) {
  StudyOptions o;
  o.methods = {"em"};
  o.repetitions = 8;
  o.profiles = 200;
  const auto end = [&](unfold_study::LargestSize largest) {
    o.largest = largest;
    return study(uniform(0, 10, 0.0005), spheres(), o, {})[0].edges.back();
  };
  const double printed = end(unfold_study::LargestSize::LargestProfile);
  EXPECT_LT(printed, 10);
  EXPECT_GT(printed, 8);
  EXPECT_GT(end(unfold_study::LargestSize::Estimated), printed);
}

TEST(UnfoldStudy, TellsHowOftenIntervalsHold) {
  StudyOptions o;
  o.methods = {"em", "inverse"};
  o.repetitions = 4;
  o.bootstrap = 30;
  o.profiles = 400;
  const auto r = study(uniform(2, 10, 0.0005), spheres(), o, {});
  EXPECT_GT(r[0].coverage, 0.5);
  EXPECT_LE(r[0].coverage, 1);
  EXPECT_TRUE(std::isnan(r[1].coverage));
}

TEST(UnfoldStudy, BadParametersAreNamed) {
  const Value d = Value::of(uniform(2, 10, 0.0005)), k = Value::of(spheres());
  const auto parameter = [&](const std::map<std::string, std::string>& p) -> std::string {
    try {
      test::run_node("UnfoldStudy", {{"distributions", d}, {"kmatrix", k}}, p);
    } catch (const Error& e) {
      return e.diagnostic().parameter;
    }
    return "none";
  };
  EXPECT_EQ(parameter({{"methods", "[em, magic]"}}), "methods");
  EXPECT_EQ(parameter({{"names", "[a, b]"}}), "names");
}

TEST(UnfoldStudy, SameBitsOnAnyNumberOfThreads) {
  const Value d = Value::of(uniform(2, 10, 0.0005)), k = Value::of(spheres());
  const auto at = [&](int threads) {
    return test::run_node("UnfoldStudy", {{"distributions", d}, {"kmatrix", k}},
                          {{"repetitions", "3"}, {"profiles", "300"}}, {}, threads)
        .output<Table>("densities")
        .rows;
  };
  EXPECT_EQ(at(1), at(3));
}

}  // namespace
}  // namespace terrazzo

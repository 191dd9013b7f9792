#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "nodes/sizes/distribution/size_laws.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using namespace distribution;

double total(const SizeDistribution& d, int power) {
  // Σ N_V·E[size^power] with sizes uniform in their class.
  double sum = 0;
  for (std::size_t i = 0; i < d.classes(); ++i) {
    const double a = d.class_edges[i], b = d.class_edges[i + 1];
    sum += d.shapes[0].N_V[i] * (std::pow(b, power + 1) - std::pow(a, power + 1)) / ((power + 1) * (b - a));
  }
  return sum;
}

TEST(Distribution, LawsHaveTheirMoments) {
  SizeLaw law;
  law.classes = 2000;
  law.mean = 4;
  law.sd = 1.2;
  law.max = 40;
  law.number_density = 0.001;
  for (const LawKind kind : {LawKind::Lognormal, LawKind::Normal}) {
    law.kind = kind;
    const SizeDistribution d = make_distribution(law, nullptr);
    const double n = total(d, 0), mean = total(d, 1) / n;
    EXPECT_NEAR(n, 0.001, 1e-9) << static_cast<int>(kind);
    EXPECT_NEAR(mean, 4, 0.01) << static_cast<int>(kind);
    EXPECT_NEAR(std::sqrt(total(d, 2) / n - mean * mean), 1.2, 0.01) << static_cast<int>(kind);
  }
  law.kind = LawKind::RosinRammler;
  law.exponent = 2;
  EXPECT_NEAR(law_cdf(law, 4), 1 - std::exp(-1), 1e-12);
  const SizeDistribution d = make_distribution(law, nullptr);
  EXPECT_NEAR(total(d, 1) / total(d, 0), 4 * std::tgamma(1.5), 0.01);
}

TEST(Distribution, IntervalsAreScaledLikeDensities) {
  SizeLaw law;
  law.kind = LawKind::Classes;
  law.class_edges = {0.5, 1, 1.5};
  law.N_V = {0.01, 0.02};
  law.low = {0.005, 0.01};
  law.high = {0.02, 0.02};
  SizeDistribution d = make_distribution(law, nullptr);
  EXPECT_EQ(d.shapes[0].low, law.low);
  EXPECT_EQ(d.shapes[0].high, law.high);
  law.number_density = 0.3;
  law.low.clear();
  d = make_distribution(law, nullptr);
  EXPECT_EQ(d.shapes[0].low, d.shapes[0].N_V);
  EXPECT_NEAR(d.shapes[0].high[0], 0.2, 1e-12);
  law.high = {0.009, 0.02};
  EXPECT_EQ(test::code_of([&] { check_law(law); }), "bad-classes");
  law.high = {0.02};
  EXPECT_EQ(test::code_of([&] { check_law(law); }), "bad-classes");
  law.high.clear();
  law.low = {0.011, 0.02};
  EXPECT_EQ(test::code_of([&] { check_law(law); }), "bad-classes");
}

TEST(Distribution, FillsTheVolumeAsked) {
  for (const LawKind kind : {LawKind::Lognormal, LawKind::Uniform, LawKind::RosinRammler, LawKind::Normal})
    for (const DensityBy density_by : {DensityBy::Number, DensityBy::Volume}) {
      SizeLaw law;
      law.kind = kind;
      law.density_by = density_by;
      law.min = 1;
      law.max = 8;
      law.volume_fraction = 0.37;
      const SizeDistribution d = make_distribution(law, nullptr);
      EXPECT_NEAR(total(d, 3) * std::numbers::pi / 6, 0.37, 1e-9) << static_cast<int>(kind);
      EXPECT_NEAR(d.volume_fraction, 0.37, 1e-9);
    }
}

// A needle, a plate and a ball of one volume have different sizes; a quarter of the particles are needles.
TEST(Distribution, ParticlesOfAllShapesHaveOneVolume) {
  Shapes shapes;
  for (const char* axes : {"[8, 1, 1]", "[4, 4, 1]", "[1, 1, 1]"}) {
    const auto one = test::run_node("Shape", {}, {{"kind", "ellipsoid"}, {"axes", axes}, {"size", "3"}});
    shapes.shapes.push_back(one.output<Shapes>("shapes").shapes[0]);
    shapes.shapes.back().probability = shapes.shapes.size() == 1 ? 0.25 : 0.375;
  }
  for (const Types types : {Types::Mixed, Types::ByClass}) {
    SizeLaw law;
    law.kind = LawKind::EqualVolume;
    law.volume = 0.125;
    law.volume_fraction = 0.5;
    law.types = types;
    const SizeDistribution d = make_distribution(law, &shapes);
    ASSERT_EQ(d.shapes.size(), 3u);
    double number = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      EXPECT_EQ(d.shapes[e].shape, static_cast<int>(e));
      EXPECT_EQ(d.shapes[e].cls, types == Types::Mixed ? 0 : static_cast<int>(e));
      const Shape& s = shapes.shapes[e];
      for (std::size_t k = 0; k < d.classes(); ++k) {
        ASSERT_LT(d.class_edges[k], d.class_edges[k + 1]);
        if (!(d.shapes[e].N_V[k] > 0)) continue;
        number += d.shapes[e].N_V[k];
        EXPECT_NEAR(d.shapes[e].N_V[k], 4 * s.probability, 1e-12);
        for (const double size : {d.class_edges[k], d.class_edges[k + 1]})
          EXPECT_NEAR(s.volume * std::pow(size / s.size(), 3), 0.125, 1e-6);
      }
    }
    EXPECT_NEAR(number, 4, 1e-12);
    EXPECT_EQ(d.volume_fraction, 0.5);
  }
  SizeLaw law;
  law.kind = LawKind::EqualVolume;
  law.volume = 0.125;
  law.number_density = 4;
  const SizeDistribution balls = make_distribution(law, nullptr);
  ASSERT_EQ(balls.classes(), 1u);
  EXPECT_NEAR(balls.d_max, std::cbrt(0.75 / std::numbers::pi), 1e-5);
  EXPECT_EQ(balls.volume_fraction, 0.5);
  law.number_density = 9;
  EXPECT_EQ(test::code_of([&] { make_distribution(law, nullptr); }), "too-full");
}

// Equal shapes share a class instead of overlapping it.
TEST(Distribution, EqualShapesOfOneVolumeShareAClass) {
  const auto ball = test::run_node("Shape", {}, {{"kind", "sphere"}}).output<Shapes>("shapes").shapes[0];
  Shapes shapes;
  shapes.shapes = {ball, ball};
  shapes.shapes[0].probability = shapes.shapes[1].probability = 0.5;
  SizeLaw law;
  law.kind = LawKind::EqualVolume;
  EXPECT_EQ(make_distribution(law, &shapes).classes(), 1u);
}

TEST(Distribution, ShapesSayWhatVolumeASizeHas) {
  const auto box = test::run_node("Shape", {}, {{"kind", "box"}, {"size", "1"}}).outputs.at("shapes");
  const auto run =
      test::run_node("Distribution", {{"shapes", box}},
                     {{"kind", "uniform"}, {"min", "1"}, {"max", "2"}, {"volume_fraction", "0.2"}});
  const Shape& s = box.as<Shapes>().shapes[0];
  EXPECT_NEAR(total(run.output<SizeDistribution>("distribution"), 3) * s.volume / std::pow(s.size(), 3), 0.2,
              1e-9);
}

TEST(Distribution, ByClassEachShapeIsAClass) {
  Shapes shapes;
  for (const double p : {1.0, 3.0}) {
    Shape s =
        test::run_node("Shape", {}, {{"kind", "box"}, {"size", "1"}}).output<Shapes>("shapes").shapes[0];
    s.probability = p;
    shapes.shapes.push_back(s);
  }
  SizeLaw law;
  const SizeDistribution mixed = make_distribution(law, &shapes);
  law.types = Types::ByClass;
  const SizeDistribution d = make_distribution(law, &shapes);
  ASSERT_EQ(d.shapes.size(), 2u);
  EXPECT_EQ(d.volume_fraction, mixed.volume_fraction);
  for (int s = 0; s < 2; ++s) {
    EXPECT_EQ(d.shapes[s].shape, s);
    EXPECT_EQ(d.shapes[s].cls, s);
    for (std::size_t j = 0; j < d.classes(); ++j)
      EXPECT_NEAR(d.shapes[s].N_V[j], (s == 0 ? 0.25 : 0.75) * mixed.shapes[0].N_V[j], 1e-12);
  }
  EXPECT_THROW(make_distribution(law, nullptr), Error);
}

TEST(Distribution, RefusesWhatIsNone) {
  const auto run = [](std::map<std::string, std::string> p) { return test::run_node("Distribution", {}, p); };
  EXPECT_THROW(run({{"kind", "classes"}}), Error);
  EXPECT_THROW(run({{"kind", "classes"}, {"class_edges", "[1, 2, 3]"}, {"N_V", "[1]"}}), Error);
  EXPECT_THROW(run({{"kind", "classes"}, {"class_edges", "[1, 3, 2]"}, {"N_V", "[1, 1]"}}), Error);
  EXPECT_THROW(run({{"kind", "classes"}, {"class_edges", "[1, 2]"}, {"N_V", "[0]"}}), Error);
  EXPECT_THROW(run({{"kind", "classes"}, {"class_edges", "[1, 2]"}, {"N_V", "[5]"}}),
               Error);  // more than full
  EXPECT_THROW(run({{"kind", "uniform"}, {"min", "3"}, {"max", "2"}}), Error);
  EXPECT_THROW(run({{"volume_fraction", "0.2"}, {"number_density", "1"}}), Error);
  EXPECT_THROW(run({{"sd", "nan"}}), Error);
}

}  // namespace
}  // namespace terrazzo

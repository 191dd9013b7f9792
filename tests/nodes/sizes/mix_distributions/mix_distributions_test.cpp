#include "nodes/sizes/mix_distributions/mix_distributions.h"

#include <gtest/gtest.h>

#include <numeric>

#include "nodes/sizes/distribution/size_laws.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {
using mix_distributions::mix;
using mix_distributions::Mixture;

Shapes shape(const std::string& kind) {
  return test::run_node("Shape", {}, {{"kind", kind}, {"size", "1"}}).output<Shapes>("shapes");
}

SizeDistribution uniform(double low, double high, int classes, double fraction, const Shapes& shapes) {
  distribution::SizeLaw law;
  law.kind = distribution::LawKind::Uniform;
  law.min = low;
  law.max = high;
  law.classes = classes;
  law.volume_fraction = fraction;
  return distribution::make_distribution(law, &shapes);
}

double number(const SizeDistribution& d, int cls, double low, double high) {
  double sum = 0;
  for (const auto& e : d.shapes)
    for (std::size_t k = 0; e.cls == cls && k < d.classes(); ++k)
      if (d.class_edges[k] >= low - 1e-9 && d.class_edges[k + 1] <= high + 1e-9) sum += e.N_V[k];
  return sum;
}

TEST(MixDistributions, EveryKindKeepsItsNumbers) {
  const Shapes ball = shape("sphere"), cube = shape("box");
  const SizeDistribution a = uniform(2, 8, 3, 0.2, ball), b = uniform(1, 5, 4, 0.1, cube);
  const Mixture m = mix({&a, &b}, {&ball, &cube});
  EXPECT_EQ(m.distribution.class_edges, (std::vector<double>{1, 2, 3, 4, 5, 6, 8}));
  EXPECT_NEAR(m.distribution.volume_fraction, 0.3, 1e-12);
  EXPECT_EQ(m.distribution.d_max, 8);
  const double of_a = number(a, 0, 0, 9), of_b = number(b, 0, 0, 9);
  EXPECT_NEAR(number(m.distribution, 0, 0, 9), of_a, 1e-12 * of_a);
  EXPECT_NEAR(number(m.distribution, 1, 0, 9), of_b, 1e-12 * of_b);
  EXPECT_NEAR(number(m.distribution, 0, 2, 3), of_a / 6, 1e-12 * of_a);  // half of the class from 2 to 4
  EXPECT_EQ(number(m.distribution, 0, 1, 2), 0);
  ASSERT_EQ(m.shapes.shapes.size(), 2u);
  EXPECT_EQ(m.shapes.shapes[0].cls, 0);
  EXPECT_EQ(m.shapes.shapes[1].cls, 1);
  EXPECT_NEAR(m.shapes.shapes[0].probability, of_a / (of_a + of_b), 1e-12);
}

TEST(MixDistributions, RandomEdgesLoseNothing) {
  const Shapes ball = shape("sphere");
  for (int seed = 1; seed <= 50; ++seed) {
    Random r(seed);
    std::vector<SizeDistribution> kinds;
    std::vector<const SizeDistribution*> list;
    std::vector<const Shapes*> sets;
    const int count = 1 + static_cast<int>(r.below(4));
    for (int i = 0; i < count; ++i) {
      const double low = r.uniform(0, 3);
      kinds.push_back(uniform(low, low + r.uniform(0.1, 5), 1 + static_cast<int>(r.below(7)), 0.1, ball));
    }
    for (const auto& k : kinds) {
      list.push_back(&k);
      sets.push_back(&ball);
    }
    const Mixture m = mix(list, sets);
    for (int i = 0; i < count; ++i) {
      const double expected = number(kinds[i], 0, 0, 100);
      EXPECT_NEAR(number(m.distribution, i, 0, 100), expected, 1e-9 * expected);
    }
  }
}

TEST(MixDistributions, ClassesOfADistributionKeepTheirOrder) {
  const Shapes ball = shape("sphere"), cube = shape("box");
  const SizeDistribution a = uniform(2, 8, 3, 0.1, ball), b = uniform(1, 5, 4, 0.1, cube);
  const Mixture two = mix({&a, &b}, {&ball, &cube});
  const Mixture three = mix({&two.distribution, &a}, {&two.shapes, &ball});
  ASSERT_EQ(three.shapes.shapes.size(), 3u);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(three.shapes.shapes[c].cls, c);
  EXPECT_NEAR(number(three.distribution, 2, 0, 9), number(a, 0, 0, 9), 1e-12);
  Shapes unnamed = two.shapes;
  unnamed.shapes[1].cls = -1;
  EXPECT_EQ(test::code_of([&] { mix({&two.distribution}, {&unnamed}); }), "mixed-classes");
}

TEST(MixDistributions, BadInputIsNamed) {
  const Shapes ball = shape("sphere");
  const SizeDistribution good = uniform(2, 8, 3, 0.6, ball);
  const auto code = [&](const SizeDistribution& d) { return test::code_of([&] { mix({&d}, {&ball}); }); };
  EXPECT_EQ(test::code_of([&] { mix({&good, &good}, {&ball}); }), "wrong-count");
  EXPECT_EQ(test::code_of([&] { mix({&good, &good}, {&ball, &ball}); }), "too-dense");
  SizeDistribution d = good;
  d.volume_fraction = 0;
  EXPECT_EQ(code(d), "relative-densities");
  d = good;
  d.shapes[0].shape = 1;
  EXPECT_EQ(code(d), "bad-distribution");
  d = good;
  d.shapes[0].N_V[1] = std::nan("");
  EXPECT_EQ(code(d), "bad-distribution");
  d = good;
  d.class_edges[1] = 1;
  EXPECT_EQ(code(d), "bad-distribution");
  d = good;
  d.shapes.clear();
  EXPECT_EQ(code(d), "bad-distribution");
}

}  // namespace
}  // namespace terrazzo

#include "nodes/common/statistics/anova.h"

#include <gtest/gtest.h>

#include <cmath>

#include "runtime/random.h"

namespace terrazzo {
namespace {

const AnovaFactors kNames{"method", "shape"};

TEST(Anova, TailsOfTheFDistribution) {
  // From tables: the 5 % points.
  EXPECT_NEAR(f_tail(4.0847, 1, 40), 0.05, 1e-4);
  EXPECT_NEAR(f_tail(3.3541, 2, 27), 0.05, 1e-4);
  EXPECT_NEAR(f_tail(1, 7, 7), 0.5, 1e-12);
  EXPECT_EQ(f_tail(0, 3, 9), 1);
}

TEST(Anova, BalancedSquaresAddUp) {
  // Two by two with two values each, computed by hand: grand mean 5; methods 3 and 7; shapes 4.5 and 5.5.
  const auto e = two_way_anova(anova_cells({2, 3, 3, 4, 6, 7, 7, 8}, {"a", "a", "a", "a", "b", "b", "b", "b"},
                                           {"x", "x", "y", "y", "x", "x", "y", "y"}),
                               kNames);
  ASSERT_EQ(e.size(), 3u);
  EXPECT_NEAR(e[0].squares, 32, 1e-9);
  EXPECT_NEAR(e[1].squares, 2, 1e-9);
  EXPECT_NEAR(e[2].squares, 0, 1e-9);
  for (const auto& effect : e) {
    EXPECT_NEAR(effect.error_squares, 2, 1e-9);
    EXPECT_EQ(effect.error_freedom, 4);
  }
  EXPECT_NEAR(e[0].f, 64, 1e-6);
  EXPECT_NEAR(e[0].p, 0.00132390, 1e-7);
  EXPECT_NEAR(e[2].p, 1, 1e-6);
  EXPECT_EQ(e[2].name, "method × shape");
}

// Reference: statsmodels 0.13.5, anova_lm(ols("y ~ C(a)*C(b)"), typ=1) and anova_lm(ols("y ~ C(a)"), typ=1).
TEST(Anova, UnbalancedValuesAgreeWithStatsmodels) {
  const std::vector<double> y{2.1, 3.4, 2.8, 5.0, 4.1, 6.2, 7.7, 3.3, 2.2, 8.1, 9.4, 6.6, 5.9};
  std::vector<std::string> a, b;
  for (const char c : std::string("xxxxyyyyyzzzz")) a.emplace_back(1, c);
  for (const char c : std::string("pqqppqqpqpqqp")) b.emplace_back(1, c);
  const auto cells = anova_cells(y, a, b);
  const auto two = two_way_anova(cells, kNames);
  ASSERT_EQ(two.size(), 3u);
  const double squares[] = {36.4232692308, 2.03203125, 2.50380208333},
               f[] = {4.68480831657, 0.522725010718, 0.322042284253},
               p[] = {0.051133834318, 0.493125161118, 0.734858884369}, freedom[] = {2, 1, 2};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(two[i].squares, squares[i], 1e-9);
    EXPECT_EQ(two[i].freedom, freedom[i]);
    EXPECT_NEAR(two[i].error_squares, 27.2116666667, 1e-9);
    EXPECT_EQ(two[i].error_freedom, 7);
    EXPECT_NEAR(two[i].f, f[i], 1e-9);
    EXPECT_NEAR(two[i].p, p[i], 1e-9);
    EXPECT_EQ(two[i].epsilon, 1);
  }
  const auto one = one_way_anova(cells, kNames);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_NEAR(one[0].error_squares, 31.7475, 1e-9);
  EXPECT_EQ(one[0].error_freedom, 10);
  EXPECT_NEAR(one[0].f, 5.73639959536, 1e-9);
  EXPECT_NEAR(one[0].p, 0.0219056773466, 1e-9);
}

TEST(Anova, ChanceIsSignificantAsOftenAsItSays) {
  int below = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Random r(seed, 1);
    std::vector<double> y;
    std::vector<std::string> m, s;
    for (int i = 0; i < 48; ++i) {
      y.push_back(r.normal());
      m.push_back(std::string(1, static_cast<char>('a' + i % 4)));
      s.push_back(std::string(1, static_cast<char>('a' + i / 4 % 3)));
    }
    below += two_way_anova(anova_cells(y, m, s), kNames)[0].p < 0.1;
  }
  EXPECT_NEAR(below / 300.0, 0.1, 0.06);
}

// Five people, three methods, two shapes. F, p: statsmodels 0.13.5, AnovaRM. Sums of squares and ε: NumPy,
// from the means' differences and from Box's formula tr(D)² / (freedom · tr(D²)), D the doubly centered
// covariance.
TEST(Anova, RepeatedMeasuresAgreeWithStatsmodels) {
  Eigen::MatrixXd y(5, 6);
  y << 3.1, 4.0, 5.2, 4.4, 6.3, 9.1,  //
      2.0, 2.9, 6.1, 5.0, 5.5, 7.2,   //
      4.4, 4.1, 4.9, 6.6, 8.0, 9.9,   //
      1.2, 3.3, 3.7, 2.5, 6.6, 6.1,   //
      2.7, 5.0, 4.6, 5.9, 4.8, 8.3;
  const auto e = repeated_anova(y, 3, 2, kNames);
  ASSERT_EQ(e.size(), 3u);
  const double squares[] = {77.1886666667, 7.70133333333, 4.61666666667},
               error[] = {6.99133333333, 4.31866666667, 6.42333333333}, freedom[] = {2, 1, 2},
               f[] = {44.1624868885, 7.13306576104, 2.87493513233},
               p[] = {4.75777993187e-05, 0.0557607019042, 0.114594967605},
               epsilon[] = {0.77491596705, 1, 0.879911386343},
               corrected[] = {0.000286696793283, 0.0557607019042, 0.12505004355};
  for (std::size_t i = 0; i < 3; ++i) {
    SCOPED_TRACE(e[i].name);
    EXPECT_NEAR(e[i].squares, squares[i], 1e-9);
    EXPECT_NEAR(e[i].error_squares, error[i], 1e-9);
    EXPECT_EQ(e[i].freedom, freedom[i]);
    EXPECT_EQ(e[i].error_freedom, 4 * freedom[i]);
    EXPECT_NEAR(e[i].f, f[i], 1e-8);
    EXPECT_NEAR(e[i].p, p[i], 1e-10);
    EXPECT_NEAR(e[i].epsilon, epsilon[i], 1e-9);
    EXPECT_NEAR(e[i].corrected_p, corrected[i], 1e-10);
  }
  // What people have in common with themselves does not matter.
  for (int i = 0; i < 5; ++i) y.row(i).array() += 10 * i;
  EXPECT_NEAR(repeated_anova(y, 3, 2, kNames)[0].f, f[0], 1e-8);
}

// People who differ by chance and, in how methods affect them, more for one method than for the others:
// without the correction, chance is significant too often.
TEST(Anova, TheCorrectionKeepsItsLevelWithUnequalVariances) {
  int plain = 0, corrected = 0;
  constexpr int kTrials = 1000;
  for (std::uint64_t seed = 0; seed < kTrials; ++seed) {
    Random r(seed, 2);
    Eigen::MatrixXd y(10, 5);
    for (int i = 0; i < 10; ++i) {
      const double own = 5 * r.normal();
      for (int j = 0; j < 5; ++j) y(i, j) = own + (j == 0 ? 5 : 0.5) * r.normal();
    }
    const auto e = repeated_anova(y, 5, 1, kNames);
    ASSERT_EQ(e.size(), 1u);
    plain += e[0].p < 0.05;
    corrected += e[0].corrected_p < 0.05;
  }
  EXPECT_GT(plain / double{kTrials}, 0.07);
  EXPECT_NEAR(corrected / double{kTrials}, 0.05, 0.02);
}

TEST(Anova, ValuesThatDoNotVaryHaveNoF) {
  // Everyone was always right: rounding errors must not become an effect.
  const auto same =
      two_way_anova(anova_cells(std::vector<double>(8, 0.1), {"a", "a", "a", "a", "b", "b", "b", "b"},
                                {"x", "x", "y", "y", "x", "x", "y", "y"}),
                    kNames);
  for (const auto& e : same) {
    EXPECT_EQ(e.squares, 0);
    EXPECT_TRUE(std::isnan(e.f) && std::isnan(e.p));
  }
  for (const auto& e : repeated_anova(Eigen::MatrixXd::Constant(4, 6, 1.0 / 3), 3, 2, kNames))
    EXPECT_TRUE(std::isnan(e.f) && std::isnan(e.p));
  // Different means without any error.
  const auto exact =
      one_way_anova(anova_cells({1, 1, 2, 2}, {"a", "a", "b", "b"}, {"x", "x", "x", "x"}), kNames);
  ASSERT_EQ(exact.size(), 1u);
  EXPECT_EQ(exact[0].p, 0);
  // Nothing is left for the error.
  EXPECT_TRUE(std::isnan(two_way_anova(anova_cells({1, 2}, {"a", "b"}, {"x", "x"}), kNames)[0].p));
  EXPECT_TRUE(std::isnan(repeated_anova(Eigen::MatrixXd::Random(1, 6), 3, 2, kNames)[0].p));
}

}  // namespace
}  // namespace terrazzo

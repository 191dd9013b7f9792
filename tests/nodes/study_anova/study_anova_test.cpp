#include <gtest/gtest.h>

#include <cmath>

#include "nodes/study_anova/anova.h"
#include "nodes/study_anova/answers.h"
#include "runtime/random.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

using namespace study_anova;

TEST(StudyAnova, TailsOfTheFDistribution) {
  // From tables: the 5 % points.
  EXPECT_NEAR(f_tail(4.0847, 1, 40), 0.05, 1e-4);
  EXPECT_NEAR(f_tail(3.3541, 2, 27), 0.05, 1e-4);
  EXPECT_NEAR(f_tail(1, 7, 7), 0.5, 1e-12);
  EXPECT_EQ(f_tail(0, 3, 9), 1);
}

TEST(StudyAnova, BalancedSquaresAddUp) {
  // Two by two with two answers each, computed by hand: grand mean 5; methods 3 and 7; shapes 4.5 and 5.5.
  const std::vector<double> y{2, 3, 3, 4, 6, 7, 7, 8};
  const std::vector<std::string> m{"a", "a", "a", "a", "b", "b", "b", "b"},
      s{"x", "x", "y", "y", "x", "x", "y", "y"};
  const auto e = two_way(y, m, s);
  ASSERT_EQ(e.size(), 4u);
  EXPECT_NEAR(e[0].squares, 32, 1e-9);
  EXPECT_NEAR(e[1].squares, 2, 1e-9);
  EXPECT_NEAR(e[2].squares, 0, 1e-9);
  EXPECT_NEAR(e[3].squares, 2, 1e-9);
  EXPECT_EQ(e[3].freedom, 4);
  EXPECT_NEAR(e[0].f, 64, 1e-6);
  EXPECT_LT(e[0].p, 0.01);
  EXPECT_NEAR(e[2].p, 1, 1e-6);
}

TEST(StudyAnova, ChanceIsSignificantAsOftenAsItSays) {
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
    below += two_way(y, m, s)[0].p < 0.1;
  }
  EXPECT_NEAR(below / 300.0, 0.1, 0.06);
}

TEST(StudyAnova, FilesAreReadByTheirColumns) {
  const auto key =
      read_key("screen,shape,method,decoy\n1,smooth,csg,left\n2,smooth,original,none\n", "key.csv");
  const auto a =
      read_answers("screen,participant,seconds,choice\n1,7,2.5,right\n\n2,7,1,left\n", "a.csv", key);
  ASSERT_EQ(a.size(), 2u);
  EXPECT_EQ(a[0].method, "csg");
  EXPECT_EQ(a[0].choice, "right");
  EXPECT_EQ(a[0].seconds, 2.5);
  const std::string header = "participant,screen,choice,seconds\n";
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,9,left,1\n", "a", key); }), "no-such-screen");
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,1,up,1\n", "a", key); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,1,left,soon\n", "a", key); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { read_answers(header + "1,1\n", "a", key); }), "malformed-row");
  EXPECT_EQ(test::code_of([&] { read_answers("", "a", key); }), "no-column");
  EXPECT_EQ(test::code_of([&] { two_way({1, 2}, {"a", "b"}, {"x", "x"}); }), "too-few-answers");
}

}  // namespace
}  // namespace terrazzo

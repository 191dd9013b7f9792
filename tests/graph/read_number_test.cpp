#include "graph/text/read_number.h"

#include <gtest/gtest.h>

#include <cmath>

namespace terrazzo {
namespace {

TEST(ReadNumber, TakesTheWholeText) {
  EXPECT_EQ(read_number("0.5"), 0.5);
  EXPECT_EQ(read_number("+3"), 3);
  EXPECT_EQ(read_number("-1e-3"), -1e-3);
  EXPECT_TRUE(std::isinf(read_number("-inf").value()));
  EXPECT_TRUE(std::isnan(read_number("nan").value()));
  for (const char* wrong : {"", "0,5", "1 ", " 1", "1x", "+-1", "+", "x", "1e999"})
    EXPECT_FALSE(read_number(wrong)) << wrong;
}

TEST(ReadNumber, ReadsLists) {
  EXPECT_EQ(read_numbers(" 1, 2.5 -3e1\n,4 "), (std::vector<double>{1, 2.5, -30, 4}));
  EXPECT_EQ(read_numbers(""), std::vector<double>());
  for (const char* wrong : {"1 x", "1;2", "1.2.3", "1-2"}) EXPECT_FALSE(read_numbers(wrong)) << wrong;
}

TEST(ReadNumber, LeavesTheRest) {
  std::string_view text = " 1.5,2";
  EXPECT_EQ(take_number(text), 1.5);
  EXPECT_EQ(text, ",2");
  EXPECT_FALSE(take_number(text));
  EXPECT_EQ(text, ",2");
}

}  // namespace
}  // namespace terrazzo

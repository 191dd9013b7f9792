#include <gtest/gtest.h>

#include "nodes/data/image.h"
#include "nodes/data/table.h"
#include "tests/support/code_of.h"
#include "tests/support/run_node.h"

namespace terrazzo {
namespace {

double entry(const Table& t, int dx, int dy, int home, int remote) {
  for (std::size_t r = 0; r < t.rows.size(); ++r)
    if (t.number(r, "dx pixels") == dx && t.number(r, "dy pixels") == dy && t.number(r, "home") == home &&
        t.number(r, "remote") == remote)
      return t.number(r, "probability");
  ADD_FAILURE() << "no such entry";
  return -1;
}

// Columns of black, black, white: everything about their pairs can be counted by hand.
TEST(CooccurrenceMatrix, IsThatOfAStripedPicture) {
  Image stripes(9, 4, 1, 1);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 9; ++x) stripes.at(x, y) = Vec3f::Constant(x % 3 == 2 ? 1.0f : 0.0f);
  const auto run = test::run_node("CooccurrenceMatrix", {{"image", Value::of(stripes)}},
                                  {{"levels", "2"}, {"extent", "3"}});
  const Table& t = run.output<Table>("table");
  ASSERT_EQ(t.rows.size(), 49u * 4);
  EXPECT_DOUBLE_EQ(entry(t, 0, 0, 1, 1), 2.0 / 3);  // the histogram
  EXPECT_DOUBLE_EQ(entry(t, 0, 0, 1, 2), 0);
  EXPECT_DOUBLE_EQ(entry(t, 0, 2, 1, 1), 2.0 / 3);  // the same along columns
  EXPECT_DOUBLE_EQ(entry(t, 3, 1, 2, 2), 2.0 / 6);  // a period of three
  EXPECT_DOUBLE_EQ(entry(t, 1, 0, 2, 2), 0);
  EXPECT_DOUBLE_EQ(entry(t, 1, 0, 1, 1), 3.0 / 8);  // of eight pairs of columns, three are both black
  EXPECT_DOUBLE_EQ(entry(t, 1, 0, 1, 2), 3.0 / 8);
  EXPECT_DOUBLE_EQ(entry(t, 1, 0, 2, 1), 2.0 / 8);
  EXPECT_DOUBLE_EQ(entry(t, -1, 0, 1, 2), 2.0 / 8);  // the opposite offset swaps the levels
  for (int dx = -3; dx <= 3; ++dx) {
    double sum = 0;
    for (const int h : {1, 2})
      for (const int r : {1, 2}) sum += entry(t, dx, 1, h, r);
    EXPECT_DOUBLE_EQ(sum, 1);
  }
  EXPECT_LT((run.output<Image>("quantized").at(2, 0) - Vec3f::Ones()).norm(), 1e-5f);
}

TEST(CooccurrenceMatrix, RejectsWhatItCannotMeasure) {
  const auto code = [](Image image, const std::map<std::string, std::string>& parameters) {
    return test::code_of([&] {
      test::run_node("CooccurrenceMatrix", {{"image", Value::of(std::move(image))}}, parameters);
    });
  };
  EXPECT_EQ(code(Image(), {}), "empty-image");
  EXPECT_EQ(code(Image(4, 4, 1, 1), {}), "one-color");
  Image two(4, 4, 1, 1);
  two.at(1, 1) = Vec3f::Ones();
  EXPECT_EQ(code(two, {{"level", "3"}}), "bad-value");
}

}  // namespace
}  // namespace terrazzo

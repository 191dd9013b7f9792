#include "graph/parameter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "graph/text/nearest.h"

namespace terrazzo {
namespace {

std::optional<ParameterValue> read(const Parameter& p, std::vector<std::string> items, bool list = false) {
  std::string why;
  auto v = read_parameter(p, {list, std::move(items)}, why);
  EXPECT_EQ(v.has_value(), why.empty()) << why;
  return v;
}

TEST(Parameter, NumbersAreReadWholeAndInRange) {
  const Parameter p = Parameter::number("x", 1).above(0);
  EXPECT_EQ(std::get<double>(*read(p, {"2.5"})), 2.5);
  EXPECT_EQ(canonical(*read(p, {"2"})), canonical(*read(p, {"2.0"})));
  for (const auto* bad : {"", "abc", "1x", "nan", ".nan", "inf", "0", "-1"})
    EXPECT_FALSE(read(p, {bad})) << bad;
  EXPECT_FALSE(read(p, {"1", "2"}, true));
  EXPECT_FALSE(read(Parameter::integer("n", 1), {"1.5"}));
}

TEST(Parameter, ListsTakeOneOrSeveral) {
  const Parameter p = Parameter::numbers("size", {1}).count(1, 3).above(0);
  EXPECT_EQ(std::get<std::vector<double>>(*read(p, {"2"})).size(), 1u);
  EXPECT_EQ(std::get<std::vector<double>>(*read(p, {"1", "2", "3"}, true)).size(), 3u);
  EXPECT_FALSE(read(p, {"1", "2", "3", "4"}, true));
  EXPECT_FALSE(read(p, {}, true));
}

TEST(Parameter, KeywordsStandBesideValues) {
  const Parameter p = Parameter::with_keyword(ParameterKind::Int, "clusters", "auto").range(2, 12);
  EXPECT_EQ(std::get<std::string>(*read(p, {"auto"})), "auto");
  EXPECT_EQ(std::get<std::int64_t>(*read(p, {"3"})), 3);
  EXPECT_FALSE(read(p, {"atuo"}));
}

TEST(Parameter, ColorsAreLinear) {
  const Parameter p = Parameter::color("c", 0, 0, 0);
  const auto hex = std::get<std::vector<double>>(*read(p, {"#ff8000"}));
  EXPECT_DOUBLE_EQ(hex[0], 1);
  EXPECT_NEAR(hex[1], 0.21586050, 1e-7);  // sRGB 128 / 255
  EXPECT_DOUBLE_EQ(hex[2], 0);
  for (const auto* bad : {"ff8000", "#ff80", "#ff80zz", "red"}) EXPECT_FALSE(read(p, {bad})) << bad;
}

TEST(Nearest, FindsWhatWasMeant) {
  EXPECT_EQ(nearest("Segmnet", {"Section", "Segment", "Shape"}), "Segment");
  EXPECT_EQ(nearest("pixelsize", {"path", "pixel_size"}), "pixel_size");
  EXPECT_EQ(nearest("qqqqqqqq", {"path", "pixel_size"}), "");
}

}  // namespace
}  // namespace terrazzo

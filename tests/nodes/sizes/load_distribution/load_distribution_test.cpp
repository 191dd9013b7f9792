#include <gtest/gtest.h>

#include "nodes/sizes/load_distribution/read_distribution.h"
#include "runtime/json_text.h"
#include "tests/support/code_of.h"
#include "tests/support/replaced.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {
using namespace load_distribution;

SizeDistribution two_entries() {
  SizeDistribution d;
  d.class_edges = {0, 0.1 + 0.2, 1e17};
  d.shapes = {{-1, 0, {0.25, 1e-300}, {0, 0}, {1.0 / 3, 5e-324}}, {2147483647, 5, {0, 1}, {0, 1}, {0, 1}}};
  d.volume_fraction = 1.0 / 7;
  d.d_max = 1e17;
  d.goodness_of_fit = 1.3;
  return d;
}

std::string text_of(const SizeDistribution& d) {
  return json_text(value_type<SizeDistribution>().describe(&d));
}

TEST(LoadDistribution, GivesWhatExportWrote) {
  for (const SizeDistribution& d : {two_entries(), SizeDistribution{}}) {
    const auto run = test::run_node("LoadDistribution", {}, {{"path", test::exported_json(d)}});
    EXPECT_EQ(test::bytes_of(run.output<SizeDistribution>("distribution")), test::bytes_of(d));
    EXPECT_EQ(run.metrics.at("entries"), d.shapes.size());
  }
}

TEST(LoadDistribution, WrongFieldsAreNamed) {
  const auto code = [](const std::string& from, const std::string& to) {
    const std::string text = test::replaced(text_of(two_entries()), from, to);
    return test::code_of([&] { read_distribution(text, "t.json"); });
  };
  EXPECT_EQ(code("{", "["), "unreadable-file");
  EXPECT_EQ(code("\"class_edges\":[0.0,", "\"class_edges\":[1e17,"), "bad-distribution");
  EXPECT_EQ(code("\"class_edges\":[0.0,", "\"class_edges\":["), "bad-distribution");
  EXPECT_EQ(code("\"shape\":-1", "\"shape\":-2"), "bad-distribution");
  EXPECT_EQ(code("\"class\":5", "\"class\":0.5"), "bad-distribution");
  EXPECT_EQ(code("\"N_V\":[0.25,", "\"N_V\":[-0.25,"), "bad-distribution");
  EXPECT_EQ(code("\"N_V\":[0.25,", "\"N_V\":[\"0.25\","), "bad-distribution");
  EXPECT_EQ(code("\"d_max\"", "\"d\""), "bad-distribution");
}

}  // namespace
}  // namespace terrazzo

#include <gtest/gtest.h>

#include "nodes/sizes/load_kmatrix/read_kmatrix.h"
#include "runtime/json_text.h"
#include "tests/support/code_of.h"
#include "tests/support/replaced.h"
#include "tests/support/stored_values.h"

namespace terrazzo {
namespace {
using namespace load_kmatrix;

KMatrix two_shapes() {
  KMatrix k;
  k.classes = 2;
  k.averaging = "upper_edge";
  k.residual = 1.0 / 7;
  k.shapes.resize(2);
  for (auto& e : k.shapes) {
    e.probability = 0.5;
    e.mean_caliper = 1.0 / 3;
    e.max_section_area = 1e-300;
    e.volume = 1e300;
    e.profiles_per_caliper = 1.1;
    e.cdf = {0, 0.1, 1.0 / 3, 1};
    e.K = (Eigen::MatrixXd(2, 2) << 0.25, 0.1 + 0.2, 0, 1e-17).finished();
  }
  k.shapes[1].cls = 3;
  return k;
}

std::string text_of(const KMatrix& k) { return json_text(value_type<KMatrix>().describe(&k)); }

TEST(LoadKMatrix, GivesWhatExportWrote) {
  const KMatrix k = two_shapes();
  const auto run = test::run_node("LoadKMatrix", {}, {{"path", test::exported_json(k)}});
  EXPECT_EQ(test::bytes_of(run.output<KMatrix>("kmatrix")), test::bytes_of(k));
  EXPECT_EQ(run.output<KMatrix>("kmatrix").shapes[0].K(0, 1), 0.1 + 0.2);  // not the transposed matrix
  EXPECT_EQ(run.metrics.at("classes"), 2);
}

TEST(LoadKMatrix, WrongFieldsAreNamed) {
  const auto code = [](const std::string& from, const std::string& to) {
    const std::string text = test::replaced(text_of(two_shapes()), from, to);
    return test::code_of([&] { read_kmatrix(text, "t.json"); });
  };
  EXPECT_EQ(code("{", "["), "unreadable-file");
  EXPECT_EQ(code("\"classes\":2", "\"classes\":0"), "unreadable-file");
  EXPECT_EQ(code("\"classes\":2", "\"classes\":5000"), "unreadable-file");
  EXPECT_EQ(code("\"classes\":2", "\"classes\":3"), "bad-kmatrix");
  EXPECT_EQ(code("upper_edge", "lower_edge"), "unreadable-file");
  EXPECT_EQ(code("\"cdf\"", "\"pdf\""), "bad-kmatrix");
  EXPECT_EQ(code("\"cdf\":[0.0,0.1,", "\"cdf\":[0.1,0.0,"), "bad-kmatrix");
  EXPECT_EQ(code("\"cdf\":[0.0,0.1,0.3333333333333333,1.0]", "\"cdf\":[1.0]"), "bad-kmatrix");
  EXPECT_EQ(code(",1.0]", ",0.9]"), "bad-kmatrix");
  EXPECT_EQ(code("\"K\":[[0.25,", "\"K\":[[-0.25,"), "bad-kmatrix");
  EXPECT_EQ(code("\"K\":[[0.25,", "\"K\":[[null,"), "bad-kmatrix");
  EXPECT_EQ(code("\"K\":[[0.25,", "\"K\":[["), "bad-kmatrix");
  EXPECT_EQ(code("\"mean_caliper\":0.", "\"mean_caliper\":-0."), "bad-kmatrix");
}

}  // namespace
}  // namespace terrazzo

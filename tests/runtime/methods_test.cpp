// The paragraph on a graph's methods.
#include "runtime/report/methods.h"

#include <gtest/gtest.h>

#include "graph/registry.h"
#include "runtime/run_result.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {

void nothing(Context&) {}

Registry types() {
  Registry out;
  out.add(NodeType("Grow", 3)
              .doc_("Grows crystals as in Rec. 709. Slowly.")
              .source_("Saltykov 1958 (spheres; disks); None: copies")
              .output("out", "Number", "A number")
              .parameter(Parameter::number("rate", 2).unit_("mm").doc_("Rate"))
              .parameter(
                  Parameter::with_keyword(ParameterKind::Number, "limit", "auto").unit_("mm").doc_("Limit"))
              .parameter(Parameter::seed())
              .compute_(nothing));
  out.add(NodeType("Cut", 1)
              .doc_("Cuts them")
              .source_("See Grow, method two; Wicksell 1925.")
              .input_list("in", {"Number"}, "Numbers")
              .output("out", "Number", "A number")
              .compute_(nothing));
  out.add(NodeType("Put", 1)
              .doc_("Writes.")
              .input("in", "Number", "A number")
              .parameter(Parameter::output_path("path").doc_("File"))
              .writes_files_()
              .compute_(nothing));
  return out;
}

std::string text_of(const std::string& yaml, const std::vector<std::string>& targets = {}) {
  const Registry registry = types();
  Diagnostics found;
  const Graph graph = load_graph_text("terrazzo: 1\nname: Study\n" + yaml, "g.yaml", registry, {}, found);
  EXPECT_FALSE(has_errors(found));
  return methods_text(graph, target_nodes(graph, targets), registry, "9.9");
}

TEST(Methods, NameVersionsSeedsSettingsAndSources) {
  EXPECT_EQ(
      text_of(
          "nodes:\n  a: {type: Grow, params: {rate: 3, limit: auto}}\n  b: {type: Grow, params: {rate: 2, "
          "limit: 4, seed: 7}}\n  c: {type: Cut, inputs: {in: [a.out, b.out]}}\n  d: {type: Put, inputs: "
          "{in: c.out}, params: {path: x.csv}}\n"),
      "Results were computed with Terrazzo 9.9 (graph “Study”) in these steps. Grow (version 3; a) grows "
      "crystals as in Rec. 709 [1]; rate = 3 mm, seed = 1. Grow (version 3; b) grows crystals as in Rec. 709 "
      "[1]; limit = 4 mm, seed = 7. Cut (version 1; c) cuts them [1, 2]. Other settings have the defaults of "
      "these versions.\n\nSources:\n[1] Saltykov 1958 (spheres; disks)\n[2] Wicksell 1925\n");
}

TEST(Methods, LeaveOutWhatTheTargetDoesNotNeed) {
  const std::string text = text_of(
      "nodes:\n  a: {type: Grow}\n  b: {type: Grow, params: {rate: 5}}\n  c: {type: Grow}\n", {"a", "c"});
  EXPECT_EQ(text.find("rate"), std::string::npos);
  EXPECT_NE(text.find("(version 3; a, c)"), std::string::npos) << text;  // equal settings
}

TEST(Methods, FailWithoutASinglePlainNode) {
  EXPECT_EQ(test::code_of([] { text_of("nodes: {}\n"); }), "nothing-to-describe");
}

}  // namespace
}  // namespace terrazzo

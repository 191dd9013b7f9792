#include "runtime/clients/studio/live/graph_parameter.h"

#include <gtest/gtest.h>

#include "graph/graph.h"
#include "tests/support/arithmetic.h"
#include "tests/support/code_of.h"

namespace terrazzo {
namespace {
using studio::with_graph_parameter;

studio::NewGraphParameter made(const std::string& text, const std::string& node, const std::string& name) {
  const std::filesystem::path file = "/nowhere/graph.yaml";
  return with_graph_parameter(read_graph(text, file), file, test::arithmetic(), node, name);
}

TEST(GraphParameter, HasTheDeclarationAndTheValue) {
  const std::string text =
      "# first\nterrazzo: 1\nnodes:\n  a: {type: Constant, params: {value: 5}}  # kept\n  b: {type: "
      "Constant, "
      "params: {value: 7}}\n";
  const auto one = made(text, "a", "value");
  EXPECT_EQ(one.name, "value");
  EXPECT_NE(one.text.find("a: {type: Constant, params: {value: \"${value}\"}}  # kept"), std::string::npos)
      << one.text;
  const auto two = made(one.text, "b", "value");
  EXPECT_EQ(two.name, "b_value");
  Diagnostics found;
  const Graph graph = load_graph_text(two.text, "/nowhere/graph.yaml", test::arithmetic(), {}, found);
  ASSERT_TRUE(found.empty()) << found[0].text() << two.text;
  ASSERT_EQ(graph.parameters.size(), 2u);
  const auto* type = test::arithmetic().find("Constant");
  EXPECT_EQ(graph.parameters[0].declaration.kind, type->find_parameter("value")->kind);
  EXPECT_EQ(std::get<double>(graph.nodes[graph.find("a")].parameters.at("value").value), 5);
  EXPECT_EQ(std::get<double>(graph.nodes[graph.find("b")].parameters.at("value").value), 7);
  EXPECT_EQ(test::code_of([&] { made(one.text, "a", "value"); }), "cannot-edit");
  EXPECT_EQ(test::code_of([&] { made(text, "c", "value"); }), "unknown-node");
  EXPECT_EQ(test::code_of([&] { made(text, "a", "gone"); }), "unknown-parameter");
}

}  // namespace
}  // namespace terrazzo

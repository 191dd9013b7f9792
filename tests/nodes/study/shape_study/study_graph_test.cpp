// The study as the paper has it: graphs/papers/2008_study.yaml at its defaults.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "graph/graph.h"
#include "tests/support/all_nodes.h"
#include "tests/support/program.h"

namespace terrazzo {
namespace {

double number(const GraphNode& node, const char* name) {
  return std::get<double>(node.parameters.at(name).value);
}

std::int64_t whole(const GraphNode& node, const char* name) {
  return std::get<std::int64_t>(node.parameters.at(name).value);
}

TEST(ShapeStudyGraph, PacksAsManyParticlesOfOneVolumeAsThePaper) {
  Diagnostics found;
  const Graph graph =
      load_graph(test::source_folder() / "graphs/papers/2008_study.yaml", test::all_nodes(), {}, found);
  ASSERT_FALSE(has_errors(found));
  int packings = 0, complex = 0;
  std::set<std::int64_t> packed_with, cut_with;
  for (const auto& node : graph.nodes) {
    if (node.type->name == "Section") {
      EXPECT_EQ(whole(node, "planes"), 20) << node.path;
      cut_with.insert(whole(node, "seed"));
      EXPECT_EQ(number(node, "width") / number(node, "pixel_size"), 250) << node.path;
    }
    if (node.type->name != "Anneal") continue;
    ++packings;
    packed_with.insert(whole(node, "seed"));
    // A volume whose particles were shrunk or left out would differ from the others in more than shape.
    EXPECT_EQ(std::get<std::string>(node.parameters.at("on_jam").value), "fail") << node.path;
    const auto& sizes = graph.nodes.at(static_cast<std::size_t>(node.inputs.at("distribution").at(0).node));
    EXPECT_EQ(std::get<std::string>(sizes.parameters.at("kind").value), "equal_volume") << node.path;
    EXPECT_EQ(number(sizes, "volume"), 0.125) << node.path;
    const double edge = std::get<std::vector<double>>(node.parameters.at("size").value).at(0);
    const double count = std::pow(edge, 3) * number(sizes, "volume_fraction") / number(sizes, "volume");
    const bool is_complex = node.path.find("complex") != std::string::npos;
    complex += is_complex;
    EXPECT_NEAR(count, is_complex ? 3500 : 4000, 1e-9) << node.path;
    // The shapes of the packing are those whose volume the sizes were computed from.
    const Wire &packed = node.inputs.at("shapes").at(0), &sized = sizes.inputs.at("shapes").at(0);
    EXPECT_EQ(packed.node, sized.node) << node.path;
    EXPECT_EQ(packed.port, sized.port) << node.path;
  }
  EXPECT_EQ(packings, 24);
  EXPECT_EQ(complex, 6);
  // With equal seeds, an original and its decoy would show the same arrangement.
  EXPECT_EQ(packed_with.size(), 24u);
  EXPECT_EQ(cut_with.size(), 24u);
}

}  // namespace
}  // namespace terrazzo

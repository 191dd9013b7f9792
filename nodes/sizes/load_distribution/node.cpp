#include "graph/node_type.h"
#include "nodes/common/io/json_input.h"
#include "nodes/sizes/load_distribution/read_distribution.h"
#include "runtime/context.h"

namespace terrazzo::load_distribution {
namespace {

void compute(Context& c) {
  SizeDistribution d = read_distribution(json_text_in(c), c.files("path")[0].string());
  c.metric("entries", d.shapes.size());
  c.metric("classes", d.classes());
  c.metric("volume_fraction", d.volume_fraction);
  c.metric("d_max", d.d_max);
  c.output("distribution", std::move(d));
}

}  // namespace
}  // namespace terrazzo::load_distribution

namespace terrazzo {

NodeType load_distribution_node() {
  using namespace load_distribution;
  return NodeType("LoadDistribution", 1)
      .doc_(
          "Reads a size distribution that Export wrote to .json, without loss of precision. Distribution "
          "makes one from a law or a list of classes.")
      .output("distribution", "SizeDistribution", "Particles per volume of each shape, class and size class")
      .parameter(Parameter::input_path("path").doc_("JSON file of a size distribution"))
      .compute_(compute);
}

}  // namespace terrazzo

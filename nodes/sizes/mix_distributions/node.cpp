#include "graph/node_type.h"
#include "nodes/sizes/mix_distributions/mix_distributions.h"
#include "runtime/context.h"

namespace terrazzo::mix_distributions {
namespace {

void compute(Context& c) {
  std::vector<const SizeDistribution*> distributions;
  std::vector<const Shapes*> sets;
  for (const Value& v : c.list("distributions")) distributions.push_back(&v.as<SizeDistribution>());
  for (const Value& v : c.list("shapes")) sets.push_back(&v.as<Shapes>());
  Mixture all = mix(distributions, sets);
  c.metric("volume_fraction", all.distribution.volume_fraction);
  c.metric("shapes", all.shapes.shapes.size());
  c.output("distribution", std::move(all.distribution));
  c.output("shapes", std::move(all.shapes));
}

}  // namespace
}  // namespace terrazzo::mix_distributions

namespace terrazzo {

NodeType mix_distributions_node() {
  using namespace mix_distributions;
  return NodeType("MixDistributions", 1)
      .doc_(
          "Joins kinds of particles, each with its own sizes and shapes, into one population. Each kind "
          "becomes a class, to which Colorize can give its own colors.")
      .source_("Jagnow, Dorsey, Rushmeier 2004, sections 3.3 (eq. 9) and 4.2")
      .input_list("distributions", {"SizeDistribution"}, "Sizes of each kind")
      .input_list("shapes", {"Shapes"}, "Shapes of each kind, in the same order")
      .output("distribution", "SizeDistribution", "Sizes of all kinds, class by class")
      .output("shapes", "Shapes", "Shapes of all kinds, with their classes")
      .compute_(compute);
}

}  // namespace terrazzo
